from __future__ import annotations

import pytest
from shoecal_msgs.action import Calibrate

from reliability.killed_nodes import (
    LATE_STAGES,
    NODES,
    REST_S,
    ROW,
    STAGES,
    SUPPORTS,
    TOLD_S,
    Suite,
    Try,
    draw,
    judged,
    of_motion,
)
from reliability.live_world import live_world
from reliability.row import Result
from shoecal_ros.calibrator.calibration_job import DRAW_SHARE, SOLVE_SHARE
from shoecal_ros.calibrator.run_series import PLAN_SHARE, REACH_SHARE


def test_a_robot_whose_planner_is_killed_comes_to_rest() -> None:
    """One kill takes half a minute; the row does the others."""
    with live_world() as world:
        found = Suite(world).kill_at("planner", "moving", 3.0, 0)
    assert found.stage == "moving"
    assert found.rest_s < REST_S, found.told
    assert "has fallen silent: start it again" in found.reason


def test_all_nodes_are_killed_at_all_moments() -> None:
    drawn = [draw(index, 0) for index in range(ROW.tries)]
    assert {node for node, _, _ in drawn} == set(NODES)
    assert {stage for _, stage, _ in drawn} == {*STAGES, *LATE_STAGES}
    moving = [after_s for _, stage, after_s in drawn if stage == "moving"]
    standing_s = 1.5
    assert min(moving) < standing_s < max(moving) < 6.0


@pytest.mark.parametrize("support", [1, 2])
def test_how_far_a_motion_is_follows_from_what_is_told(support: int) -> None:
    for done in (0.0, 0.6, 1.0):
        of_run = REACH_SHARE + PLAN_SHARE + (1.0 - REACH_SHARE - PLAN_SHARE) * done
        share = (support - 1 + of_run) / SUPPORTS
        progress = DRAW_SHARE + (1.0 - DRAW_SHARE - SOLVE_SHARE) * share
        told = Calibrate.Feedback(stage="moving", support=support, progress=progress)
        assert of_motion(told) == pytest.approx(done, abs=1e-5)


def test_who_is_told_too_late_has_failed() -> None:
    rests = Try("planner", "moving", 2.0, 1.0, "")
    late = Try("model", "drawing", 0.5, TOLD_S + 0.1, "")
    result = judged([rests, late], 2, "")
    assert (result.tried, result.failed, result.worst) == (2, 1, late.told)


def test_what_was_not_tried_does_not_count() -> None:
    rests, never = (Try("planner", "moving", seconds, 1.0, "") for seconds in (2.0, REST_S + 1.0))
    assert judged([rests, rests], 2, "") == Result(2, 0, rests.told, 2.0)
    assert judged([rests, never], 2, "").failed == 1
    for found, count, tried, failed in (
        ([], 5, 1, 1),
        ([rests, rests], 5, 3, 1),
        ([never, rests], 5, 3, 2),
        ([rests, rests], 2, 2, 1),  # the calibration after the last one did not begin
        ([rests, never], 2, 2, 1),
    ):
        result = judged(found, count, "not told")
        assert (result.tried, result.failed, result.worst) == (tried, failed, "not told")
