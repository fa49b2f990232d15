"""Time in which this process was awake: its own sleep is no silence of others."""

from __future__ import annotations

import time
from collections.abc import Callable

LONGEST_S = 0.25
"""More than this between two looks was sleep: a node looks every `node.WATCH_S` at least."""


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

    def __call__(self) -> float:
        """Time awake [s]; to be asked again and again."""
        now_s = self._monotonic()
        self._awake_s += min(now_s - self._looked_s, LONGEST_S)
        self._looked_s = now_s
        return self._awake_s
