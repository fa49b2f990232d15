from __future__ import annotations

import numpy as np
import pytest
from shoecal_msgs.action import Calibrate

from reliability.killed_nodes import (
    LATE_STAGES,
    REST_S,
    ROW,
    STAGES,
    SUPPORTS,
    VICTIMS,
    Scene,
    draw,
    of_motion,
)
from reliability.live_world import live_world
from shoecal_ros.calibrator.calibration_job import DRAW_SHARE, SOLVE_SHARE
from shoecal_ros.calibrator.run_series import PLAN_SHARE, REACH_SHARE


def test_a_robot_whose_planner_is_killed_comes_to_rest() -> None:
    """One kill takes half a minute; the row does the others."""
    with live_world() as world:
        rest_s, _ = Scene(world).kill(("planner", "calibrator"), "moving", 3.0, 0)
    busy_s = 1.2  # granted while other tests run: what is left of the motion lasts for longer
    assert rest_s < REST_S[True] + busy_s


def test_all_nodes_are_killed_at_all_moments() -> None:
    drawn = [draw(number, np.random.default_rng([0, number])) for number in range(ROW.tries)]
    assert {nodes for nodes, _, _ in drawn} == set(VICTIMS)
    assert {stage for _, stage, _ in drawn} == {*STAGES, *LATE_STAGES}
    moving = [after_s for _, stage, after_s in drawn if stage == "moving"]
    standing_s = 1.5
    assert min(moving) < standing_s < max(moving) < 6.0


@pytest.mark.parametrize("support", [1, 2])
def test_how_far_a_motion_is_follows_from_the_progress(support: int) -> None:
    for done in (0.0, 0.6, 1.0):
        of_run = REACH_SHARE + PLAN_SHARE + (1.0 - REACH_SHARE - PLAN_SHARE) * done
        share = (support - 1 + of_run) / SUPPORTS
        progress = DRAW_SHARE + (1.0 - DRAW_SHARE - SOLVE_SHARE) * share
        feedback = Calibrate.Feedback(stage="moving", support=support, progress=progress)
        assert of_motion(feedback) == pytest.approx(done, abs=1e-5)
