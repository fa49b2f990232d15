"""Set points of a trajectory, one after the other, for robots that know no trajectories."""

from __future__ import annotations

import math

import numpy as np

# Trajectories need it; loaded at the first one it would halt the node as the robot begins to move.
import scipy.interpolate  # noqa: F401

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot

STOP_S = 0.4
"""In which joints come to rest, and in which they pass over to a new trajectory."""
PEAK = 1.5
"""Of the speed of passing over, over its mean."""
REPEATED_S = 1.0
"""For so long the last set point is sent again and again, should a message be lost."""
_GRID_S = 0.02
"""Between the points that remember a motion which another one takes the place of."""


class Stream:
    """One trajectory at a time; silent before the first one and after the end of each.

    Whatever happens, no joint's speed jumps. A stop is made on the trajectory itself, whose time
    runs out ever more slowly: that way has been checked, and a robot on it is in balance. A new
    trajectory is passed over to: both ways keep within limits, and so does whatever lies between
    them. Where it is the next piece of the same motion they are the same way.

    Attributes:
        names: joints that are commanded, in the order of set points.
    """

    def __init__(self, robot: Robot) -> None:
        self.names: tuple[str, ...] = ()
        self._robot = robot
        self._columns = np.zeros(0, dtype=np.int64)
        self._coming: JointTrajectory | None = None
        self._leaving = self._standing(robot.posture)
        self._begun_s = 0.0
        self._stopped_s = math.inf

    @property
    def active(self) -> bool:
        """Whether there is something to send."""
        return self._coming is not None

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
        grid = np.arange(0.0, STOP_S + _GRID_S, _GRID_S)
        measured = np.clip(measured, self._robot.lower, self._robot.upper)
        angles, speeds = np.tile(measured, (len(grid), 1)), np.zeros((len(grid), len(measured)))
        if self.at(now_s) is not None:
            going_on, going = self._states(now_s + grid)
            angles[:, self._columns] = going_on[:, self._columns]
            speeds[:, self._columns] = going[:, self._columns]
            # Those that the new one does not name come to rest, too.
            names += tuple(name for name in self.names if name not in names)
        self._coming = trajectory.full(self._robot, angles[-1])
        self._leaving = JointTrajectory(self._robot.joint_names, grid, angles, speeds)
        self.names = names
        self._columns = np.array([self._robot.joint(name) for name in names])
        self._begun_s, self._stopped_s = now_s, math.inf

    def at(self, now_s: float) -> FloatArray | None:
        """(k,) set points at a time [rad]; None where nothing is to be sent."""
        if self._coming is None:
            return None
        if now_s > self._rest_s + REPEATED_S:
            self._coming = None
            return None
        angles: FloatArray = self._states(np.array([now_s]))[0][0, self._columns]
        return angles

    def under_way(self, now_s: float) -> bool:
        """Whether joints are still commanded to move."""
        return self._coming is not None and now_s < self._rest_s

    def stop(self, now_s: float) -> None:
        """Come to rest within STOP_S; what comes to rest so already is left to it."""
        if self.under_way(now_s) and math.isinf(self._stopped_s):
            self._stopped_s = now_s

    def rest(self, given_s: float, now_s: float) -> None:
        """A robot that was given no set point since a time [s] holds that one.

        What it was to do meanwhile is past: it stays there, and the next trajectory begins there.
        """
        if self._coming is not None:
            self._coming = self._leaving = self._standing(self._states(np.array([given_s]))[0][0])
            self._begun_s, self._stopped_s = now_s - STOP_S, math.inf

    @property
    def _rest_s(self) -> float:
        """When joints are at rest, monotonic [s]."""
        assert self._coming is not None
        ends_s = self._begun_s + max(self._coming.duration, STOP_S)
        return min(self._stopped_s + STOP_S, ends_s)

    def _states(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(T, m) angles [rad] and speeds [rad/s] that all joints are commanded at times (T,)."""
        assert self._coming is not None
        elapsed, pace = self._clock(times)
        left, leaving = self._leaving.at(elapsed), self._leaving.rates(elapsed)
        followed, following = self._coming.at(elapsed), self._coming.rates(elapsed)
        done = np.minimum(elapsed / STOP_S, 1.0)[:, None]
        share, growth = done**2 * (3.0 - 2.0 * done), 6.0 * done * (1.0 - done) / STOP_S
        # The cubics that remember a motion may swing a little beyond a limit that it touched.
        left = np.clip(left, self._robot.lower, self._robot.upper)
        angles = left + share * (followed - left)
        speeds = leaving + share * (following - leaving) + growth * (followed - left)
        return angles, pace[:, None] * speeds

    def _clock(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Times on the trajectory [s] and how fast they pass, evenly slower during a stop."""
        since = np.clip(times - self._stopped_s, 0.0, STOP_S)
        on_time = np.minimum(times, self._stopped_s) - self._begun_s
        return on_time + since * (1.0 - 0.5 * since / STOP_S), 1.0 - since / STOP_S

    def _standing(self, angles: FloatArray) -> JointTrajectory:
        return JointTrajectory(self._robot.joint_names, np.zeros(1), angles[None])
