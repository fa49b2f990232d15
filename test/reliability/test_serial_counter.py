from __future__ import annotations

import pytest

from reliability.serial_counter import ROW
from shoecal_ros.serial import continuity


def test_a_share_of_the_row() -> None:
    result = ROW.run(0, 1000, 0, lambda _: None)
    assert result.failed == 0, result.worst


def test_loss_that_is_not_counted_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(continuity, "_lost", lambda _count, _frame: [])
    result = ROW.run(0, 20, 0, lambda _: None)
    assert result.failed
    assert "frames were lost, 0 counted" in result.worst
