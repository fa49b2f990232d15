"""Does the torso lean as the motion makes it?"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import BodyStates

MISPLACED = 0.5
"""rad; a sensor that disagrees with a standing robot's posture by more has other axes."""


def upward(body: BodyStates, foot: int) -> FloatArray:
    """(3,) unit upward normal of the floor in the base frame, by a foot flat on it.

    Args:
        body: of one instant.
        foot: 0 left, 1 right; the one that stands.
    """
    rotation = body.left_rotation[0]
    normal: FloatArray = rotation[:, 2] if foot == 0 else rotation @ body.rotation[0][:, 2]
    return normal


def angle_between(one: FloatArray, other: FloatArray) -> float:
    """Between two unit vectors (3,), accurate for small angles too [rad]."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


class Tilt:
    """How far the torso leans from what the joint angles say, beyond what it did at the start.

    What differs at the start is the floor's slope and how the sensor is mounted: a small turn
    that stays.
    """

    def __init__(self, measured: FloatArray, expected: FloatArray) -> None:
        """The robot stands.

        Args:
            measured: (3,) upward direction in the base's frame, by the sensor.
            expected: (3,) the same, by the joint angles.
        """
        self.offset = angle_between(measured, expected)
        self._turn = _least_turn(expected, measured)

    @property
    def usable(self) -> bool:
        """Whether sensor and posture have the same axes."""
        return self.offset < MISPLACED

    def error(self, measured: FloatArray, expected: FloatArray) -> float:
        """Angle between the torso's upward direction (3,) and where it should be (3,) [rad]."""
        return angle_between(measured, self._turn @ expected)


def _least_turn(start: FloatArray, end: FloatArray) -> FloatArray:
    """(3, 3) smallest rotation from one unit vector (3,) to another, not opposite one."""
    axis, cosine = np.cross(start, end), float(start @ end)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    # Rodrigues' formula with the axis' length as the sine; opposite vectors are never used.
    turn: FloatArray = np.eye(3) + cross + cross @ cross / max(1.0 + cosine, 1e-9)
    return turn
