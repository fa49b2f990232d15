from __future__ import annotations

from reliability.serial_replug import ROW


def test_a_share_of_the_row() -> None:
    result = ROW.run(0, 10, 0, lambda _: None)
    assert result.failed == 0, result.worst
