"""The second robot is made up; that it could stand is not."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from core.planning.bodies import load_body
from core.planning.motions import SETTINGS
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.posture import StanceSolver
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.robot.double_support import DoubleSupport


def test_the_urdf_weighs_about_what_the_robot_file_says() -> None:
    body = load_body("wren")
    robot, worn = body.robot, body.shoe.mass
    bare = pin.buildModelFromUrdf(str(robot.urdf), pin.JointModelFreeFlyer())
    assert sum(inertia.mass for inertia in bare.inertias) == pytest.approx(
        robot.mass - worn, rel=0.05
    )


def test_it_stands_all_over_its_range_without_strain() -> None:
    body = load_body("wren")
    robot, solver = body.robot, StanceSolver(body.legs, SETTINGS)
    supports = Feasible(robot, SETTINGS).apart()
    drawn = np.random.default_rng(1).choice(len(supports), 25, replace=False)
    stances = np.array([robot.from_legs(solver.solve(supports[index])) for index in drawn])
    seen = track(robot, stances)
    assert np.abs(seen.torques).max() < 0.4 * robot.effort_limit[robot.legs].min()
    assert seen.distances.min() > SETTINGS.capsule_clearance
    assert np.all((seen.com[:, 2] > 0.22) & (seen.com[:, 2] < 0.29))


def test_left_and_right_mirror_each_other() -> None:
    robot = load_body("wren").robot
    neutral = DoubleSupport(*(float(value) for value in robot.support_range.neutral))
    seen = track(robot, robot.posture[None])
    assert abs(seen.com[0, 1] - seen.right_translation[0, 1] / 2.0) < 1e-6
    assert neutral.dx == neutral.dtheta == 0.0
