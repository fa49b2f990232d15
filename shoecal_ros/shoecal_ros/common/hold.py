"""The command that brings a robot to rest where it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.robot import Robot


def hold(robot: Robot, angles: NDArray[np.float64], stop_time: float) -> JointTrajectory:
    """Come to rest at all joint angles (m,) [rad] within a time [s]."""
    # Encoders may show angles a little beyond a limit; no robot takes such a command.
    held = np.clip(robot.from_legs(angles[robot.legs], angles), robot.lower, robot.upper)
    names = tuple(robot.joint_names[index] for index in robot.moved)
    return JointTrajectory(names, np.array([stop_time]), held[None, robot.moved])
