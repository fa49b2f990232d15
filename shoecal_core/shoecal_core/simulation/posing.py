"""Putting the physics of a robot on the floor, motionless, in given joint angles."""

from __future__ import annotations

import math

import mujoco

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.robot import Robot
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.faults import SupportNotReachedError
from shoecal_core.simulation.shoe_physics import SoleReader

_DROP = 5e-4
"""m; from how high the soles are put down."""
_UNEVEN_HEIGHT, _UNEVEN_TILT = 0.01, 0.05
"""m, rad; soles farther from one level plane than this do not stand flat."""


class Posing:
    """Poses one robot."""

    def __init__(self, robot: Robot, physics: RobotPhysics) -> None:
        self._robot, self._physics = robot, physics
        self._soles = SoleReader(physics.model)
        self._scratch = mujoco.MjData(physics.model)

    def check(self, angles: FloatArray) -> None:
        """Refuse motor angles (m,) [rad] that do not put both soles on one plane.

        Raises:
            SupportNotReachedError: for those.
        """
        self._pose(self._scratch, angles)
        position, rotation = self._soles.pose(self._scratch)
        height = abs(float(position[1, 2]))
        tilt = math.acos(min(1.0, float(rotation[1, 2, 2])))
        if height > _UNEVEN_HEIGHT or tilt > _UNEVEN_TILT:
            raise SupportNotReachedError(
                f"robot '{self._robot.name}' cannot stand with these joint angles: its soles are "
                f"{height * 1e3:.0f} mm apart in height and {tilt:.2f} rad in tilt; give angles "
                "that put both soles flat"
            )

    def put(self, data: mujoco.MjData, angles: FloatArray) -> None:
        """Motor angles (m,) [rad], the left sole flat, the lowest corner just above the floor."""
        self._pose(data, angles)
        lowest = min(
            float((position + rotation[:, :2] @ corner)[2])
            for position, rotation, foot in zip(
                *self._soles.pose(data), self._robot.feet, strict=True
            )
            for corner in foot.outline
        )
        data.qpos[2] += _DROP - lowest
        mujoco.mj_kinematics(self._physics.model, data)

    def _pose(self, data: mujoco.MjData, angles: FloatArray) -> None:
        """Joints at these angles, left sole on the world's origin, all else at zero."""
        model = self._physics.model
        mujoco.mj_resetData(model, data)
        data.qpos[self._physics.positions] = angles
        mujoco.mj_kinematics(model, data)
        position, rotation = self._soles.pose(data)
        to_left = rotation[0].T
        data.qpos[:3] = -to_left @ position[0]
        mujoco.mju_mat2Quat(data.qpos[3:7], to_left.ravel())
        mujoco.mj_kinematics(model, data)
