"""Does the robot follow the trajectory that it was sent?"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from shoecal_core.simulation.trajectory import JointTrajectory

FloatArray = NDArray[np.float64]
_LOOKS = 9
"""Places on the trajectory that a measurement is compared with, over the span of lateness."""


class Verdict(Enum):
    """What measured angles say."""

    FOLLOWS = "follows"
    ARRIVED = "arrived"
    LOST = "lost"


@dataclass(frozen=True)
class Look:
    """One measurement held against the trajectory.

    Attributes:
        verdict: what it says.
        joint: that is farthest off.
        error: by how much [rad].
        progress: 0 to 1 of the trajectory's time.
    """

    verdict: Verdict
    joint: str
    error: float
    progress: float


class Follower:
    """Compares measured angles with where the robot should be.

    A robot is late: it starts when the message arrives, and its motors trail. So a measurement
    is compared with the trajectory over a span of time, and the nearest place counts.
    """

    def __init__(
        self, trajectory: JointTrajectory, start_ns: int, error_bound: float, late_s: float
    ) -> None:
        """A trajectory that was sent.

        Args:
            trajectory: of all joints that are measured, in that order.
            start_ns: when it was sent [ns].
            error_bound: a joint farther off than this is lost [rad].
            late_s: how late the robot may be [s].
        """
        self._trajectory = trajectory
        self._start_ns = start_ns
        self._bound = error_bound
        self._late_s = late_s

    def expected(self, stamp_ns: int) -> FloatArray:
        """(m,) where the robot should be at a time [rad]."""
        return self._trajectory.at(np.array((stamp_ns - self._start_ns) / 1e9))

    def look(self, stamp_ns: int, angles: FloatArray) -> Look:
        """Take measured angles (m,) [rad]; those that are NaN do not count."""
        trajectory = self._trajectory
        elapsed = (stamp_ns - self._start_ns) / 1e9
        times = np.linspace(elapsed - self._late_s, elapsed, _LOOKS)
        errors = np.nan_to_num(np.abs(trajectory.at(times) - angles), nan=0.0)
        nearest = errors[int(np.argmin(errors.max(axis=1)))]
        joint = int(np.argmax(nearest))
        error = float(nearest[joint])
        if error > self._bound:
            verdict = Verdict.LOST
        elif elapsed - self._late_s >= trajectory.duration:
            verdict = Verdict.ARRIVED
        else:
            verdict = Verdict.FOLLOWS
        progress = min(1.0, max(0.0, elapsed / max(trajectory.duration, 1e-9)))
        return Look(verdict, trajectory.names[joint], error, progress)
