from __future__ import annotations

from reliability.peers import RIVALS, tried


def test_who_does_not_fit_is_named() -> None:
    found = tried(0, len(RIVALS) + 1, 0, lambda _: None)
    assert len({one.what for one in found}) == len(RIVALS) + 1
