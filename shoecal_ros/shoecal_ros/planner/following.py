"""Does the robot follow the trajectory that it was sent?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.renewal import Renewal

_MOVED, _SHARE = 2e-3, 0.2
"""rad, share of the planned way: a part that moved no joint farther brought no progress."""
_LOOKS = 9
"""Places on the trajectory that a measurement is compared with, over the span of lateness."""
_CONFIRMED, _CONFIRMED_NS = 3, 100_000_000
"""Measurements in a row that are far off, or the time between two of them: one alone may lie."""


class FollowingState(Enum):
    """What measured angles say."""

    FOLLOWS = "follows"
    ARRIVED = "arrived"
    DOUBTFUL = "doubtful"
    LOST = "lost"


@dataclass(frozen=True)
class FollowingError:
    """One measurement held against the trajectory.

    Attributes:
        verdict: what it says.
        joint: that is farthest off.
        error: by how much [rad].
        progress: 0 to 1 of the trajectory's time.
    """

    verdict: FollowingState
    joint: str
    error: float
    progress: float


class Follower:
    """Compares measured angles with where the robot should be.

    A robot is late: it starts when the message arrives, and its motors trail. So a measurement
    is compared with what was commanded over a span of time, and the nearest place counts. One
    measurement far off may be a false one, or another sender's: the next ones decide.
    """

    def __init__(
        self,
        trajectory: JointTrajectory,
        renewal: Renewal,
        start_ns: int,
        error_bound: float,
        late_s: float,
    ) -> None:
        """A trajectory that is being sent.

        Args:
            trajectory: of all joints that are measured, in that order.
            renewal: how far it was sent.
            start_ns: when it began [ns].
            error_bound: a joint farther off than this is lost [rad].
            late_s: how late the robot may be [s].
        """
        self._trajectory = trajectory
        self._renewal = renewal
        self._start_ns = start_ns
        self._bound = error_bound
        self._late_s = late_s
        self._seen_at = trajectory.positions[0]
        self._far_off = 0
        self._far_off_since_ns = 0

    def elapsed(self, stamp_ns: int) -> float:
        """Time since the trajectory began [s]."""
        return (stamp_ns - self._start_ns) / 1e9

    def path_time(self, stamp_ns: int) -> float:
        """Time on the trajectory at which the robot should be by then [s]."""
        return self._renewal.path_time(self.elapsed(stamp_ns))

    def at_rest(self, angles: FloatArray) -> FloatArray:
        """(m,) where to stop a robot that was measured at (m,) [rad].

        There, but no joint farther than the bound from where the robot was last seen on its
        trajectory: to stop must not be a motion of its own, whatever one message says.
        """
        way = np.nan_to_num(angles - self._seen_at, nan=0.0)
        angles_at_rest: FloatArray = self._seen_at + np.clip(way, -self._bound, self._bound)
        return angles_at_rest

    def look(self, stamp_ns: int, angles: FloatArray) -> FollowingError:
        """Take measured angles (m,) [rad]; those that are NaN do not count."""
        trajectory = self._trajectory
        elapsed = self.elapsed(stamp_ns)
        times = np.linspace(elapsed - self._late_s, elapsed, _LOOKS)
        path_times = np.array([self._renewal.path_time(time) for time in times])
        places = trajectory.at(path_times)
        errors = np.nan_to_num(np.abs(places - angles), nan=0.0)
        nearest = int(np.argmin(errors.max(axis=1)))
        joint = int(np.argmax(errors[nearest]))
        error = float(errors[nearest, joint])
        if error > self._bound:
            verdict = self._judge_far_off(stamp_ns)
        else:
            self._seen_at, self._far_off = places[nearest], 0
            arrived = path_times[0] >= trajectory.duration
            verdict = FollowingState.ARRIVED if arrived else FollowingState.FOLLOWS
        progress = float(path_times[-1]) / max(trajectory.duration, 1e-9)
        return FollowingError(verdict, trajectory.names[joint], error, progress)

    def _judge_far_off(self, stamp_ns: int) -> FollowingState:
        self._far_off += 1
        if self._far_off == 1:
            self._far_off_since_ns = stamp_ns
        lasting = abs(stamp_ns - self._far_off_since_ns) >= _CONFIRMED_NS
        confirmed = self._far_off >= _CONFIRMED or lasting
        return FollowingState.LOST if confirmed else FollowingState.DOUBTFUL


class DeflectionCompensation:
    """How far a streamed motion's commands must be ahead of measurements: its motors' give.

    Attributes:
        ahead: (k,) what the next part's commands are moved by [rad].
    """

    def __init__(self, names: Sequence[str], bound: float, patience: int) -> None:
        """Nothing known yet.

        Args:
            names: of the k joints.
            bound: largest give of a joint [rad].
            patience: parts without progress after which the robot does not follow.
        """
        self.ahead = np.zeros(len(names))
        self._names = tuple(names)
        self._bound = bound
        self._patience = patience
        self._idle = 0

    def learn(self, planned: FloatArray, begun: FloatArray, ended: FloatArray) -> str:
        """Take one part that was done.

        Args:
            planned: (T, k) the part's angles [rad].
            begun, ended: (k,) measured when the robot stood before and after it [rad].

        Returns:
            Why the robot does not follow; empty when it does. `ahead` stays within its bound.
        """
        way = float(np.abs(planned[-1] - planned[0]).max())
        moved = float(np.abs(ended - begun).max())
        self._idle = 0 if moved > max(_MOVED, _SHARE * way) else self._idle + 1
        ahead = self.ahead + planned[-1] - ended
        self.ahead = np.clip(ahead, -self._bound, self._bound)
        joint = int(np.argmax(np.abs(ahead)))
        if abs(ahead[joint]) > self._bound:
            return (
                f"joint '{self._names[joint]}' stays {abs(ahead[joint]):.3f} rad behind its "
                f"commands (give {self._bound:g} rad)"
            )
        if self._idle >= self._patience:
            return f"the robot has not moved in {self._idle} parts of the motion"
        return ""
