"""Time in which this process was awake: its own sleep is no silence of others."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

LONGEST_S = 0.25
"""More than this between two looks was sleep: a node looks every `node.WATCH_S` at least."""
CATCH_UP_S = 0.1
"""After a sleep: hundreds of messages are heard in that time. With more of it a planner that was
held up for half a second would end its motion."""


class AwakeClock:
    """Monotonic; stands still while the process is stopped, starved or blocked.

    After a sleep what came meanwhile still waits to be heard. By the wall clock everybody else
    would seem to have been silent for as long.
    """

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        """It begins now."""
        self._monotonic = monotonic
        self._looked_s = monotonic()
        self._awake_s = 0.0
        self._woke_s = -math.inf

    def __call__(self) -> float:
        """Time awake [s]; to be asked again and again."""
        now_s = self._monotonic()
        passed_s = now_s - self._looked_s
        self._awake_s += min(passed_s, LONGEST_S)
        self._looked_s = now_s
        if passed_s > LONGEST_S:
            self._woke_s = self._awake_s
        return self._awake_s

    def catches_up(self) -> bool:
        """Whether what came during a sleep may still wait to be heard, older than it seems."""
        return self() - self._woke_s < CATCH_UP_S
