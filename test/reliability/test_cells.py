from __future__ import annotations

from reliability.cells import Try, break_live
from reliability.cells_live import LIVE


def test_cells_that_break_are_told_and_no_others() -> None:
    tries = {index: Try.of(index) for index in range(len(LIVE))}
    assert {one.fault for one in tries.values()} == set(LIVE)
    found = break_live(tries, 0, calibrating=False)
    assert not [one for one in found if one.failed and not one.failed.startswith("told after")]
