from __future__ import annotations

from reliability.cells import WITHIN_S, Outcome, Try, break_live
from reliability.cells_live import LIVE

HELD_UP = 4.0
"""So many times as many readings may come until the state is told where a machine is busy."""


def test_cells_that_break_are_told_and_no_others() -> None:
    tries = {index: Try.of(index) for index in range(len(LIVE))}
    assert {one.fault for one in tries.values()} == set(LIVE)
    found = break_live(tries, 0, calibrating=False)
    assert not [one for one in found if one.wrong]
    # By the robot's stamps, not by a clock: how many readings it takes, not how long.
    assert max(one.readings_s for one in found) <= HELD_UP * WITHIN_S, found


def test_what_is_late_is_told_beside_what_is_wrong() -> None:
    tried = Try.of(0)
    assert not Outcome(tried, WITHIN_S).failed
    assert Outcome(tried, 0.7).failed == "told after 0.70 s"
    assert Outcome(tried, 0.7, wrong="another cell was told, too").failed == (
        "another cell was told, too, told after 0.70 s"
    )
