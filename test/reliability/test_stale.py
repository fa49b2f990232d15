from __future__ import annotations

from reliability.stale import tried


def test_what_depends_on_what_stays_away_stops_and_comes_again() -> None:
    found = tried(4, 8, 0, lambda _: None)
    assert not any(one.wrong for one in found), [one.told for one in found]
    assert {one.what for one in found} == {
        "joints",
        "voltages",
        "voltages of the left foot",
        "voltages of the right foot",
    }
