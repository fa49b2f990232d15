from __future__ import annotations

import math

import pytest
from shoecal_msgs.msg import FootState, ShoeState, ShoeVoltages

from ros.clock import Clock
from shoecal_ros.inputs.shoe_reports import ShoeReports


def state(
    left: bool = True, right: bool = True, *, valid: bool = True, stale: bool = False
) -> ShoeState:
    feet = [
        FootState(foot=name, loaded=loaded, valid=valid, stale=stale)
        for name, loaded in (("left", left), ("right", right))
    ]
    return ShoeState(state=ShoeState.CALIBRATED, feet=feet)


def test_nothing_heard() -> None:
    reports = ShoeReports()
    assert reports.ages == {"shoe/voltages": math.inf}
    assert reports.loaded == (None, None)


def test_readings_that_stop() -> None:
    clock = Clock()
    reports = ShoeReports(clock=clock)
    reports.take_readings([ShoeVoltages()])
    clock.now += 2.0
    assert reports.ages == {"shoe/voltages": 2.0}


def test_states_that_come_at_a_rate_are_missed_and_others_are_not() -> None:
    clock = Clock()
    reports = ShoeReports(clock=clock)
    reports.take_states([state()])
    clock.now += 100.0
    assert reports.ages["shoe/state"] == 0.0, "latched: it tells changes"
    for _ in range(10):
        clock.now += 0.1
        reports.take_states([state()])
    clock.now += 2.0
    assert reports.ages["shoe/state"] == pytest.approx(2.0)


def test_a_job_is_forgotten_with_its_node() -> None:
    clock, there = Clock(), True
    reports = ShoeReports(lambda: there, clock)
    assert reports.job == ""
    for _ in range(10):
        clock.now += 0.1
        reports.take_states([ShoeState(run_id="one")])
    assert reports.job == "one"
    clock.now += 4.0
    assert not reports.job, "no states come"
    reports.take_states([ShoeState(run_id="one")])
    there = False
    assert not reports.job


def test_feet_that_carry() -> None:
    reports = ShoeReports()
    reports.take_states([state(True, False)])
    assert reports.loaded == (True, False)


@pytest.mark.parametrize("doubt", ["unconfirmed", "disagrees"])
def test_readings_under_a_doubted_calibration_are_of_use_and_say_no_load(doubt: str) -> None:
    """The robot has to move to be calibrated anew, and no load is known meanwhile."""
    clock = Clock()
    reports = ShoeReports(clock=clock)
    doubted = state(valid=False)
    setattr(doubted, doubt, True)
    for one in (state(), doubted):
        clock.now += 5.0
        reports.take_states([one])
    assert reports.ages["readings of the left foot"] == 0.0
    assert reports.loaded == (None, None)
    doubted.feet[0].status = [ShoeVoltages.NO_DATA]
    reports.take_states([doubted])
    clock.now += 1.0
    assert reports.ages["readings of the left foot"] == pytest.approx(1.0)


def test_numbers_that_are_not_valid_say_nothing() -> None:
    reports = ShoeReports()
    reports.take_states([state(valid=False)])
    assert reports.loaded == (None, None)
    reports.take_states([state(stale=True)])
    assert reports.loaded == (None, None)


def test_a_foot_is_stale_since_it_was_told() -> None:
    clock = Clock()
    reports = ShoeReports(clock=clock)
    reports.take_states([state()])
    clock.now += 5.0
    assert reports.ages["readings of the left foot"] == 0.0
    reports.take_states([state(stale=True)])
    clock.now += 1.0
    reports.take_states([state(stale=True)])
    clock.now += 1.0
    assert reports.ages["readings of the left foot"] == 2.0
    reports.take_states([state()])
    assert reports.ages["readings of the right foot"] == 0.0


def test_a_state_that_nobody_would_change_any_more_says_nothing() -> None:
    there = [True]
    reports = ShoeReports(lambda: there[0])
    reports.take_states([state()])
    assert reports.ages["shoe/state"] == 0.0
    there[0] = False
    assert reports.ages["shoe/state"] == math.inf
    assert reports.loaded == (None, None)


def test_a_foot_of_which_a_cell_breaks_tells_nothing_of_use_since_then() -> None:
    clock = Clock()
    reports = ShoeReports(clock=clock)
    reports.take_states([state()])
    assert reports.ages["readings of the left foot"] == 0.0
    for _ in range(8):
        clock.now += 0.25
        reports.take_states([state(valid=False)])
    assert reports.ages["readings of the left foot"] == 1.75
    reports.take_states([state()])
    assert reports.ages["readings of the left foot"] == 0.0


def test_feet_that_were_never_valid_do_not_fall_silent() -> None:
    reports = ShoeReports()
    reports.take_states([state(valid=False), state(valid=False, stale=True)])
    assert reports.ages["readings of the left foot"] == math.inf
