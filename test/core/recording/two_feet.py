"""Joint angles of a robot that moves on two feet that stand still."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics

ASTRIDE = DoubleSupport(0.03, -0.11, 0.2)


def leg_pairs(kinematics: Kinematics) -> Iterator[tuple[str, str]]:
    """Joints of the left and of the right leg in pairs."""
    names = kinematics.robot.joint_names
    for left, right in zip(*kinematics.robot.leg_chains, strict=True):
        yield names[left - 2], names[right - 2]


def standing(kinematics: Kinematics, support: DoubleSupport) -> FloatArray:
    """(T, m) angles of a robot that squats and leans [rad], its feet still in a double support."""
    robot, time = kinematics.robot, np.linspace(0.0, 6.0, 40)
    free = sorted(robot.between_feet)
    angles = np.tile(robot.posture, (len(time), 1))
    solution = robot.posture[free]

    def residuals(values: FloatArray, wanted: FloatArray) -> FloatArray:
        posture = robot.posture.copy()
        posture[free] = values
        state = kinematics.states(posture[None])
        turned = Rotation.from_matrix(state.rotation[0]) * Rotation.from_rotvec(
            [0.0, 0.0, -support.dtheta]
        )
        place = state.translation[0] - [support.dx, support.dy, 0.0]
        return np.concatenate([10.0 * place, turned.as_rotvec(), 1e-2 * (values - wanted)])

    sway = np.random.default_rng(3).normal(0.0, 0.15, (2, len(free)))
    for row, now in enumerate(time):
        wanted = robot.posture[free] + np.sin(now) * sway[0] + np.sin(2.0 * now) * sway[1]
        solution = least_squares(residuals, solution, args=(wanted,)).x
        angles[row, free] = solution
    return angles
