"""Set points of a trajectory, one after the other, for robots that know no trajectories."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.robot import Robot

FloatArray = NDArray[np.float64]

REPEATED_S = 1.0
"""For so long the last set point is sent again and again, should a message be lost."""


class Stream:
    """One trajectory at a time; silent before the first one and after the end of each.

    Attributes:
        names: joints that are told, in the order of set points.
    """

    def __init__(self, robot: Robot) -> None:
        self.names: tuple[str, ...] = ()
        self._robot = robot
        self._trajectory: JointTrajectory | None = None
        self._columns = np.zeros(0, dtype=np.int64)
        self._begun_s = 0.0

    @property
    def active(self) -> bool:
        """Whether there is something to send."""
        return self._trajectory is not None

    def begin(self, trajectory: JointTrajectory, measured: FloatArray, now_s: float) -> None:
        """Follow a trajectory from now on.

        Args:
            trajectory: of some joints; a first point later than at once is moved to from where the
                joints were last told to be, or are.
            measured: (m,) joint angles by now [rad].
            now_s: monotonic [s].

        Raises:
            ShoecalError: for joints that the robot does not have, and beyond limits.
        """
        start = measured.copy()
        told = self.at(now_s)
        if told is not None:
            start[self._columns] = told
        self._trajectory = trajectory.full(self._robot, start)
        self.names = trajectory.names
        self._columns = np.array([self._robot.joint(name) for name in self.names])
        self._begun_s = now_s

    def at(self, now_s: float) -> FloatArray | None:
        """(k,) set points at a time [rad]; None where nothing is to be sent."""
        if self._trajectory is None:
            return None
        elapsed = now_s - self._begun_s
        if elapsed > self._trajectory.duration + REPEATED_S:
            self._trajectory = None
            return None
        points: FloatArray = self._trajectory.at(np.array(elapsed))[self._columns]
        return points

    def under_way(self, now_s: float) -> bool:
        """Whether joints are still told to move."""
        return self._trajectory is not None and now_s - self._begun_s < self._trajectory.duration

    def stop(self, now_s: float) -> None:
        """Stay at the set points of this moment."""
        told = self.at(now_s)
        if told is not None and self._trajectory is not None:
            angles = self._trajectory.at(np.array(now_s - self._begun_s))[None]
            names = self._trajectory.names
            self._trajectory = JointTrajectory(names, np.zeros(1), np.array(angles))
            self._begun_s = now_s
