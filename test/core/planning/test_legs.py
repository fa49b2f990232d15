from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from core.planning.bodies import Body, load_body
from shoecal_core.planning.legs import FootPose, Legs, LegsError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot


def test_shared_motors_keep_to_both_joints_limits(nao: Body) -> None:
    robot = nao.robot
    model = pin.Model(robot.model)
    upper = model.upperPositionLimit.copy()
    upper[7 + robot.joint("RHipYawPitch")] = 0.2
    model.upperPositionLimit = upper
    narrow = Legs(dataclasses.replace(robot, model=model))
    column = robot.leg_names.index("LHipYawPitch")
    assert narrow.limits[1][column] == pytest.approx(0.2)
    assert nao.legs.limits[1][column] > 0.7


def test_foot_pose_of_a_support_and_back() -> None:
    support = DoubleSupport(0.03, -0.12, 0.4)
    pose = FootPose.of(support)
    assert pose.support.dx == support.dx
    assert pose.support.dtheta == pytest.approx(support.dtheta)
    point = np.array([0.02, 0.01])
    np.testing.assert_allclose(
        (pose.rotation @ [*point, 0.0] + pose.translation)[:2], support.right_to_left(point)
    )


def with_limit(robot: Robot, name: str, kind: str) -> Robot:
    model = pin.Model(robot.model)
    limits = getattr(model, kind).copy()
    limits[6 + robot.joint(name)] = 0.0
    setattr(model, kind, limits)
    return dataclasses.replace(robot, model=model)


def test_legs_that_cannot_be_planned_with(nao: Body) -> None:
    robot = nao.robot
    with pytest.raises(LegsError, match=r"nao\.yaml: legs: 6 joints .* at least 8"):
        Legs(dataclasses.replace(robot, legs=robot.legs[:6]))
    others = np.setdiff1d(np.arange(len(robot.joint_names)), robot.legs)
    left_only = np.array([*robot.legs[:6], *others[:4]])
    with pytest.raises(LegsError, match="moves the right foot"):
        Legs(dataclasses.replace(robot, legs=left_only, shared=()))
    with pytest.raises(
        LegsError, match=r"nao\.urdf: joint RKneePitch: the effort limit is 0; give"
    ):
        Legs(with_limit(robot, "RKneePitch", "effortLimit"))
    with pytest.raises(LegsError, match="joint LHipRoll: the velocity limit is 0; give"):
        Legs(with_limit(robot, "LHipRoll", "velocityLimit"))


def test_legs_without_ankle_roll() -> None:
    """Such a robot can stand, but its CoP cannot be moved sideways while it does."""
    robot = load_body("wren").robot
    kept = [index for index in robot.legs if not robot.joint_names[index].endswith("ankle_sway")]
    assert len(kept) == len(robot.legs) - 2
    with pytest.raises(LegsError, match=r"CoP sideways \(the feet have no ankle roll\); list"):
        Legs(dataclasses.replace(robot, legs=np.array(kept)))
