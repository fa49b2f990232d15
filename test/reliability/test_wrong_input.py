from __future__ import annotations

from reliability.wrong_input import run


def test_every_request_is_refused_with_a_reason() -> None:
    result = run(0, 120, 0, lambda _: None)
    assert result.failed == 0, result.worst
