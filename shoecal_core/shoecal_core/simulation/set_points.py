"""What the servos are commanded, period by period."""

from __future__ import annotations

import math

import numpy as np

# Trajectories need it; loaded at the first one it would halt a simulation that runs in real time.
import scipy.interpolate  # noqa: F401

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory

SERVO_PERIOD = 0.01
"""s; a servo takes a new command that often and moves evenly in between."""


class SetPoints:
    """A command for all joints, from a step of the physics on.

    Attributes:
        steps_per_period: of the physics, in one servo period.
    """

    def __init__(self, command: JointTrajectory, first_step: int, step: float) -> None:
        """Take a command.

        Args:
            command: for all joints.
            first_step: at which it begins.
            step: of the physics [s].
        """
        self.steps_per_period = max(1, round(SERVO_PERIOD / step))
        self._command, self._first_step, self._step = command, first_step, step
        self._first_period = first_step // self.steps_per_period
        periods = math.ceil(command.duration / (self.steps_per_period * step)) + 2
        steps = (self._first_period + np.arange(periods)) * self.steps_per_period - first_step
        self._angles = command.at(steps.astype(np.float64) * step)

    def at_period(self, period: int) -> FloatArray:
        """(m,) joint angles at the start of a servo period [rad]."""
        angles: FloatArray = self._angles[min(period - self._first_period, len(self._angles) - 1)]
        return angles

    def at_step(self, step: int) -> FloatArray:
        """(m,) joint angles at a step of the physics [rad]."""
        return self._command.at(np.array((step - self._first_step) * self._step))
