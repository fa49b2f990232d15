"""How fast the robot's time passes, compared with the wall clock."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

WINDOW_S = 1.0
"""Over so long a time it is measured: a simulation runs in bursts."""
LEAST_S = 0.2
"""Over less than that bursts would count, not the rate."""
FASTEST = 100.0
"""A simulation is not believed to be faster."""


class RobotTime:
    """Of a simulated robot by the stamps of its joint angles; a real one's passes as everybody's.

    A simulation that is slower than a robot gives everybody more time, and counts as one.
    """

    def __init__(self, *, simulated: bool, monotonic: Callable[[], float] = time.monotonic) -> None:
        """Nothing has come.

        Args:
            simulated: whether the robot is.
            monotonic: wall clock [s].
        """
        self._simulated = simulated
        self._monotonic = monotonic
        self._noted: deque[tuple[float, int]] = deque()

    def note(self, stamp_ns: int) -> None:
        """Joint angles of a time [ns] have come."""
        if not self._simulated:
            return
        now_s, noted = self._monotonic(), self._noted
        noted.append((now_s, stamp_ns))
        while now_s - noted[0][0] > WINDOW_S and len(noted) > 2:
            noted.popleft()

    @property
    def rate(self) -> float:
        """Robot's time over wall-clock time, 1 to FASTEST."""
        if not self._noted:
            return 1.0
        (begun_s, begun_ns), (ended_s, ended_ns) = self._noted[0], self._noted[-1]
        passed_s = ended_s - begun_s
        if passed_s < LEAST_S:
            return 1.0
        return min(max((ended_ns - begun_ns) / 1e9 / passed_s, 1.0), FASTEST)
