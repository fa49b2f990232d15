"""Joint angles to CoM, sole poses and modelled CoP, for many samples at once."""

from __future__ import annotations

from dataclasses import dataclass, fields

import casadi as ca
import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.symbolic import SymbolicKinematics, evaluate


@dataclass(frozen=True)
class BodyStates:
    """What joint angles say about T samples of the body.

    Attributes:
        com: (T, 2, 3) CoM in the left and in the right sole's frame [m].
        rotation: (T, 3, 3) turns vectors of the right sole's frame into the left's.
        translation: (T, 3) origin of the right sole in the left sole's frame [m].
        left_rotation: (T, 3, 3) turns vectors of the left sole's frame into the base's.
        left_translation: (T, 3) origin of the left sole in the base [m].
    """

    com: FloatArray
    rotation: FloatArray
    translation: FloatArray
    left_rotation: FloatArray
    left_translation: FloatArray

    def part(self, part: BoolArray) -> BodyStates:
        """The samples marked in `part` (T,)."""
        return BodyStates(**{one.name: getattr(self, one.name)[part] for one in fields(self)})

    @property
    def cop(self) -> FloatArray:
        """(T, 2, 2) modelled CoP in the left and in the right sole's frame [m].

        A quasi-static robot's CoP is its CoM's ground projection (paper, section IV); each
        sole is taken as flat on a level floor.
        """
        return self.com[..., :2]

    @property
    def com_in_base(self) -> FloatArray:
        """(T, 3) CoM in the base's frame [m]."""
        com: FloatArray = (
            np.einsum("tij,tj->ti", self.left_rotation, self.com[:, 0]) + self.left_translation
        )
        return com

    @property
    def yaw(self) -> FloatArray:
        """(T,) heading of the right sole seen from the left [rad]."""
        return np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])

    @property
    def right_sole(self) -> FloatArray:
        """(T, 6) pose of the right sole in the left's frame: x, y, z, tilts about x and y, yaw."""
        tilt = np.stack((self.rotation[:, 2, 1], -self.rotation[:, 2, 0]), axis=1)
        return np.concatenate((self.translation, tilt, self.yaw[:, None]), axis=1)

    def support(self) -> DoubleSupport:
        """Where the right foot stands, from the median of all samples (feet do not move)."""
        dx, dy = np.median(self.translation[:, :2], axis=0)
        return DoubleSupport(float(dx), float(dy), float(np.median(self.yaw)))


class Kinematics:
    """Forward kinematics of one robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        symbolic = SymbolicKinematics(robot)
        left, right = symbolic.soles
        outputs = [
            left.inverse_act(symbolic.com),
            right.inverse_act(symbolic.com),
            ca.reshape(left.rotation.T @ right.rotation, 9, 1),
            left.inverse_act(right.translation),
            ca.reshape(left.rotation, 9, 1),
            left.translation,
        ]
        self._body = ca.Function(
            "body", [symbolic.joint_angles], [ca.vertcat(*outputs)], {"cse": True}
        )

    def states(self, joint_angles: FloatArray) -> BodyStates:
        """Evaluate T samples.

        Args:
            joint_angles: (T, m) in `robot.joint_names`' order [rad].
        """
        expected = len(self.robot.joint_names)
        if joint_angles.ndim != 2 or joint_angles.shape[1] != expected:
            raise ShapeError("joint angles", f"(T, {expected})", joint_angles.shape)
        values = evaluate(self._body, joint_angles)
        return BodyStates(
            com=values[:, :6].reshape(-1, 2, 3),
            # CasADi stores matrices by columns.
            rotation=values[:, 6:15].reshape(-1, 3, 3).transpose(0, 2, 1),
            translation=values[:, 15:18],
            left_rotation=values[:, 18:27].reshape(-1, 3, 3).transpose(0, 2, 1),
            left_translation=values[:, 27:30],
        )
