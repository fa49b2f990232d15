"""The command that brings a robot to rest where it is, made and recognised."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot

STOP_TIME_S = 0.5
"""In which a robot comes to rest without a plan."""
HOLD_WAY = 0.2
"""rad; a command of one point that leads no joint farther stops the robot."""
LONGEST_S = 5.0
"""A robot that should take longer is stopped all the same."""
_PEAK = 1.5
"""Greatest over mean speed of a joint that goes smoothly from rest to rest, as a cubic does."""


def hold(robot: Robot, angles: FloatArray, stop_time: float) -> JointTrajectory:
    """Come to rest at all joint angles (m,) [rad] within a time [s].

    It takes longer, up to LONGEST_S, where else some joint, HOLD_WAY off, would have to be faster
    than it can. What is measured does not count here: no false joint angle may draw a stop out.
    """
    limits = robot.velocity_limit[robot.moved]
    slowest = float(np.min(limits, initial=np.inf, where=limits > 0.0))
    time = max(stop_time, min(_PEAK * HOLD_WAY / slowest, LONGEST_S))
    # Encoders may show angles a little beyond a limit; no robot takes such a command.
    held = np.clip(robot.from_legs(angles[robot.legs], angles), robot.lower, robot.upper)
    names = tuple(robot.joint_names[index] for index in robot.moved)
    return JointTrajectory(names, np.array([time]), held[None, robot.moved])


def is_hold(trajectory: JointTrajectory, robot: Robot, joint_angles: FloatArray) -> bool:
    """Whether a command stops the robot about where its joints (m,) [rad] are.

    Raises:
        NameNotFoundError: for a joint that the robot does not have.
    """
    columns = [robot.joint(name) for name in trajectory.names]
    ways = np.abs(trajectory.positions - joint_angles[columns])
    return len(trajectory.times) == 1 and bool((ways <= HOLD_WAY).all())
