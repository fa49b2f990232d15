"""Derivatives of the modelled CoP against finite differences of the model itself."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from core.model import robots
from shoecal_core.errors import ShapeError
from shoecal_core.model.kinematics import BodyStates, Kinematics
from shoecal_core.model.robot import Robot
from shoecal_core.model.sensitivity import SensitiveBody

FloatArray = NDArray[np.float64]
STEP = 1e-6


@pytest.fixture
def angles(robot: Robot) -> FloatArray:
    return robots.random_angles(robot, 3)


@pytest.fixture
def body(robot: Robot) -> SensitiveBody:
    return SensitiveBody(robot)


def support(states: BodyStates) -> FloatArray:
    return np.column_stack((states.translation[:, :2], states.yaw))


@pytest.mark.parametrize("foot", [0, 1])
def test_joint_angles(
    body: SensitiveBody, kinematics: Kinematics, robot: Robot, angles: FloatArray, foot: int
) -> None:
    found = body.at(angles, foot)
    for joint in range(len(robot.joint_names)):
        step = STEP * np.eye(len(robot.joint_names))[joint]
        up, down = kinematics.states(angles + step), kinematics.states(angles - step)
        by_cop = (up.cop[:, foot] - down.cop[:, foot]) / (2.0 * STEP)
        np.testing.assert_allclose(found.cop_by_joint[:, :, joint], by_cop, atol=1e-8)
        by_support = (support(up) - support(down)) / (2.0 * STEP)
        np.testing.assert_allclose(found.support_by_joint[:, :, joint], by_support, atol=1e-8)


def modelled_cop(robot: Robot, model: pin.Model, angles: FloatArray, foot: int) -> FloatArray:
    data = model.createData()
    places = []
    for row in angles:
        configuration = np.concatenate(([0.0] * 6, [1.0], row))
        com = pin.centerOfMass(model, data, configuration)
        pin.updateFramePlacements(model, data)
        places.append(data.oMf[robot.feet[foot].frame].actInv(com)[:2])
    return np.array(places)


@pytest.mark.parametrize("foot", [0, 1])
def test_masses_and_centres_of_the_links(
    body: SensitiveBody, robot: Robot, angles: FloatArray, foot: int
) -> None:
    found = body.at(angles, foot)
    told = modelled_cop(robot, robot.model, angles, foot)
    for index, name in enumerate(body.links):
        joint = robot.model.getJointId(name)
        for axis in range(4):
            model = robot.model.copy()
            inertia = model.inertias[joint]
            lever = np.array(inertia.lever)
            if axis < 3:
                lever[axis] += STEP
                mass, expected = inertia.mass, found.cop_by_com[:, :, index, axis]
            else:
                mass, expected = (1.0 + STEP) * inertia.mass, found.cop_by_mass[:, :, index]
            model.inertias[joint] = pin.Inertia(mass, lever, np.array(inertia.inertia))
            moved = modelled_cop(robot, model, angles, foot) - told
            np.testing.assert_allclose(expected, moved / STEP, atol=1e-6)


def test_a_whole_body_that_shifts_shifts_its_cop(body: SensitiveBody, angles: FloatArray) -> None:
    """All masses heavier alike change nothing."""
    np.testing.assert_allclose(body.at(angles).cop_by_mass.sum(axis=2), 0.0, atol=1e-12)


def test_joint_angles_of_another_robot(body: SensitiveBody) -> None:
    with pytest.raises(ShapeError, match="joint angles"):
        body.at(np.zeros((2, 3)))
