"""Joints that run out from wherever and however fast they are on their way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from shoecal_core.robot.robot import Robot

FloatArray = NDArray[np.float64]

_AT_ONCE_S = 1e-9
"""A joint at its limit goes no farther."""


@dataclass(frozen=True)
class DecelerationProfile:
    """Joints that slow down evenly until they rest.

    Attributes:
        angles, speeds: (m,) at the beginning [rad, rad/s].
        times: (m,) after which each is at rest [s].
    """

    angles: FloatArray
    speeds: FloatArray
    times: FloatArray

    @classmethod
    def within_limits(
        cls, robot: Robot, angles: FloatArray, speeds: FloatArray, time_s: float
    ) -> Self:
        """All of them at rest after a time, sooner where a joint's limit is too near for that.

        Args:
            robot: whose joints they are.
            angles, speeds: (m,) by now [rad, rad/s]; angles a little beyond a limit count as there.
            time_s: until they rest.
        """
        angles = np.clip(angles, robot.lower, robot.upper)
        room = np.where(speeds > 0.0, robot.upper - angles, angles - robot.lower)
        # Slowed down evenly, a joint goes on by half its speed times the time.
        way = 0.5 * np.abs(speeds) * time_s
        share = np.divide(room, way, out=np.ones_like(way), where=way > room)
        return cls(angles, speeds, np.maximum(time_s * share, _AT_ONCE_S))

    @property
    def end(self) -> FloatArray:
        """(m,) where they come to rest [rad]."""
        angles: FloatArray = self.angles + 0.5 * self.speeds * self.times
        return angles

    def at(self, elapsed: float) -> tuple[FloatArray, FloatArray]:
        """(m,) angles [rad] and speeds [rad/s] after a time [s]."""
        left = 1.0 - np.clip(elapsed / self.times, 0.0, 1.0)
        return self.end - 0.5 * self.speeds * self.times * left**2, self.speeds * left
