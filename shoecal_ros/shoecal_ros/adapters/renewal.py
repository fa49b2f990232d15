"""A trajectory in short goals, renewed while the adapter lives.

A controller follows what it was sent to the end, even if the sender has died. So it is never sent
more than GOAL_S, and again every PERIOD_S: a robot whose adapter is gone comes to rest within
GOAL_S.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.robot.joint_trajectory import JointTrajectory

FloatArray = NDArray[np.float64]

GOAL_S = 0.5
"""What a controller has to go on with, at most."""
PERIOD_S = 0.2
"""After which it is sent the next goal."""
_POINT_S = 0.02
"""Between the points of a goal."""


class Renewal:
    """One trajectory on its way to a controller.

    Attributes:
        done: whether its end has been handed out.
    """

    def __init__(self, trajectory: JointTrajectory, start: FloatArray, now_s: float) -> None:
        """It begins now.

        Args:
            trajectory: of k joints.
            start: (k,) where these joints are [rad].
            now_s: monotonic [s].
        """
        first = trajectory.times[0] > 0.0
        self._names = trajectory.names
        self._times = np.concatenate([[0.0][: int(first)], trajectory.times])
        self._positions = np.vstack([start[None][: int(first)], trajectory.positions])
        self._begun_s = now_s
        self._sent = 0.0
        self.done = False

    def goal(self, now_s: float) -> JointTrajectory:
        """The next GOAL_S of it, positions by linear interpolation.

        Who comes too late goes on from where the goal before has ended: no joint has to catch up.
        """
        elapsed = now_s - self._begun_s
        if elapsed > self._sent:
            self._begun_s += elapsed - self._sent
            elapsed = self._sent
        duration = float(self._times[-1])
        end = min(elapsed + GOAL_S, duration)
        count = max(1, int(np.ceil((end - elapsed) / _POINT_S)))
        times = elapsed + (end - elapsed) * np.arange(1, count + 1) / count
        positions = np.column_stack(
            [np.interp(times, self._times, column) for column in self._positions.T]
        )
        self._sent, self.done = end, end >= duration
        since = np.maximum(times - elapsed, _POINT_S * 1e-3 * np.arange(1, count + 1))
        return JointTrajectory(self._names, since, positions)
