"""Set points of a trajectory, one after the other, for robots that know no trajectories."""

from __future__ import annotations

import numpy as np

# Trajectories need it; loaded at the first one it would halt the node as the robot begins to move.
import scipy.interpolate  # noqa: F401
from numpy.typing import NDArray

from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot
from shoecal_ros.adapters.deceleration_profile import DecelerationProfile

FloatArray = NDArray[np.float64]

STOP_S = 0.4
"""In which joints come to rest, and in which they pass over to a new trajectory."""
REPEATED_S = 1.0
"""For so long the last set point is sent again and again, should a message be lost."""


class Stream:
    """One trajectory at a time; silent before the first one and after the end of each.

    Whatever happens, no joint's speed jumps. A stop is made on the trajectory itself, whose time
    runs out ever more slowly: that way has been checked, and a robot on it is in balance. A new
    trajectory is blended in while joints still run out (`DecelerationProfile`): both ways keep
    within limits, and so does whatever lies between them.

    Attributes:
        names: joints that are commanded, in the order of set points.
    """

    def __init__(self, robot: Robot) -> None:
        self.names: tuple[str, ...] = ()
        self._robot = robot
        self._trajectory: JointTrajectory | None = None
        self._deceleration = _at_rest(robot, robot.posture)
        self._columns = np.zeros(0, dtype=np.int64)
        self._begun_s = 0.0
        self._stopped_s: float | None = None

    @property
    def active(self) -> bool:
        """Whether there is something to send."""
        return self._trajectory is not None

    def begin(self, trajectory: JointTrajectory, measured: FloatArray, now_s: float) -> None:
        """Follow a trajectory from now on.

        Args:
            trajectory: of some joints; a first point later than at once is moved to from where the
                joints were last commanded to be, or are.
            measured: (m,) joint angles by now [rad].
            now_s: monotonic [s].

        Raises:
            ShoecalError: for joints that the robot does not have, and beyond limits.
        """
        names = trajectory.names
        # Joints without a command yet are where they are: they may have been moved meanwhile.
        angles, speeds = measured.copy(), np.zeros_like(measured)
        if self.at(now_s) is not None:
            reported, running = self._state(now_s)
            angles[self._columns], speeds[self._columns] = (
                reported[self._columns],
                running[self._columns],
            )
            # Those that the new one does not name come to rest, too.
            names += tuple(name for name in self.names if name not in names)
        deceleration = DecelerationProfile.within_limits(self._robot, angles, speeds, STOP_S)
        self._trajectory = trajectory.full(self._robot, deceleration.end)
        self._deceleration = deceleration
        self.names = names
        self._columns = np.array([self._robot.joint(name) for name in names])
        self._begun_s, self._stopped_s = now_s, None

    def at(self, now_s: float) -> FloatArray | None:
        """(k,) set points at a time [rad]; None where nothing is to be sent."""
        if self._trajectory is None:
            return None
        if now_s > self._rest_s + REPEATED_S:
            self._trajectory = None
            return None
        return self._state(now_s)[0][self._columns]

    def under_way(self, now_s: float) -> bool:
        """Whether joints are still commanded to move."""
        return self._trajectory is not None and now_s < self._rest_s

    def stop(self, now_s: float) -> None:
        """Come to rest within STOP_S; what comes to rest so already is left to it."""
        if self.under_way(now_s) and self._stopped_s is None:
            self._stopped_s = now_s

    @property
    def _rest_s(self) -> float:
        """When joints are at rest, monotonic [s]."""
        assert self._trajectory is not None
        if self._stopped_s is not None:
            return self._stopped_s + STOP_S
        return self._begun_s + max(self._trajectory.duration, STOP_S)

    def _state(self, now_s: float) -> tuple[FloatArray, FloatArray]:
        """(m,) angles [rad] and speeds [rad/s] that all joints are commanded."""
        assert self._trajectory is not None
        elapsed, pace = self._clock(now_s)
        run_out, running = self._deceleration.at(elapsed)
        followed = self._trajectory.at(np.array(elapsed))
        following = self._trajectory.rates(np.array(elapsed))
        done = min(elapsed / STOP_S, 1.0)
        share, growth = done**2 * (3.0 - 2.0 * done), 6.0 * done * (1.0 - done) / STOP_S
        angles = run_out + share * (followed - run_out)
        speeds = running + share * (following - running) + growth * (followed - run_out)
        return angles, pace * speeds

    def _clock(self, now_s: float) -> tuple[float, float]:
        """Time on the trajectory [s] and how fast it passes, evenly slower during a stop."""
        if self._stopped_s is None:
            return now_s - self._begun_s, 1.0
        since = min(now_s - self._stopped_s, STOP_S)
        left = 1.0 - since / STOP_S
        return self._stopped_s - self._begun_s + 0.5 * STOP_S * (1.0 - left**2), left


def _at_rest(robot: Robot, angles: FloatArray) -> DecelerationProfile:
    return DecelerationProfile.within_limits(robot, angles, np.zeros_like(angles), STOP_S)
