"""A simulated robot as MuJoCo runs it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco

from shoecal_core.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class RobotPhysics:
    """A compiled world with one robot.

    Attributes:
        model: MuJoCo's.
        positions: (m,) where each joint's motor angle stands in `qpos`.
        motor: (m,) actuator that drives each joint.
        ratio: (m,) motor angle over the angle of the actuator's own joint.
        torque_limit: (a,) of the actuators [N m].
    """

    model: mujoco.MjModel
    positions: IntArray
    motor: IntArray
    ratio: FloatArray
    torque_limit: FloatArray
