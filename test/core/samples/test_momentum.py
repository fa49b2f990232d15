"""What the angular momentum of a robot on its feet adds to its zero-moment point."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from core.robot import robots
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.momentum import angular_momentum, base_in_stance, standing_spin

TIME = np.arange(0.0, 2.0, 0.01)


def swaying(robot: Robot) -> FloatArray:
    """Joints of a robot that moves all of its body at once; the stance foot is held."""
    phase = np.random.default_rng(3).uniform(0.0, 6.0, len(robot.joint_names))
    angles: FloatArray = robot.posture + 0.1 * np.sin(4.0 * TIME[:, None] + phase)
    return angles


def zero_moment_point(robot: Robot, poses: FloatArray, index: int) -> FloatArray:
    """(2,) where the floor's force must act by the whole body's equations of motion."""
    data = robot.model.createData()
    step = TIME[1] - TIME[0]
    before, after = (
        pin.difference(robot.model, poses[at], poses[at + 1]) / step for at in (index - 1, index)
    )
    torque = pin.rnea(
        robot.model, data, poses[index], 0.5 * (before + after), (after - before) / step
    )
    placed = pin.SE3(pin.Quaternion(poses[index, 3:7]).matrix(), poses[index, :3])
    wrench = placed.act(pin.Force(torque[:6]))
    return np.asarray(np.array([-wrench.angular[1], wrench.angular[0]]) / wrench.linear[2])


@pytest.mark.parametrize("foot", [0, 1])
def test_mass_and_spin_together_are_the_whole_body_s_dynamics(foot: int) -> None:
    kinematics = robots.kinematics("nao")
    robot = kinematics.robot
    angles = swaying(robot)
    frame = np.full(len(TIME), foot)
    states = kinematics.states(angles)
    shift = standing_spin(angles, TIME, frame, kinematics)
    com = states.com[:, foot]
    acceleration = np.gradient(np.gradient(com, TIME, axis=0), TIME, axis=0)
    lift = GRAVITY + acceleration[:, 2:]
    found = com[:, :2] - com[:, 2:] / lift * acceleration[:, :2] + GRAVITY / lift * shift
    orientation, origin = base_in_stance(states, frame)
    poses = np.hstack((origin, orientation, angles))
    inside = list(range(40, 160, 10))
    wanted = np.array([zero_moment_point(robot, poses, index) for index in inside])
    assert np.abs(shift[inside]).max() > 2e-3
    np.testing.assert_allclose(found[inside], wanted, atol=6e-4)


def test_a_body_at_rest_does_not_spin() -> None:
    robot = robots.kinematics("nao").robot
    still = np.tile(swaying(robot)[:1], (len(TIME), 1))
    frame = np.zeros(len(TIME), dtype=np.int64)
    spin = standing_spin(still, TIME, frame, Kinematics(robot))
    np.testing.assert_allclose(spin, 0.0, atol=1e-9)
    poses = np.tile(np.concatenate((np.zeros(6), [1.0], still[0])), (len(TIME), 1))
    np.testing.assert_allclose(angular_momentum(poses, TIME, robot), 0.0, atol=1e-9)
