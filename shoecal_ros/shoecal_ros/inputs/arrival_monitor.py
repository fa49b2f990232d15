"""Since when an input has sent nothing."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from statistics import median

SILENT_S = 0.08
"""Without news for so long an input may be silent: reported within 0.1 s, all included."""
SILENT_PERIODS = 2.6
"""Where it comes more seldom, without news for so many of its periods: reported within three."""
LOOK_S = 0.01
"""From one look to the next where patience is longer: it ends early once news come faster."""
_INTERVALS = 9
RATE_S = 2.0
"""Rates are given over so long a time."""


class ArrivalMonitor:
    """When something usable last came, by the wall clock.

    Attributes:
        at: that time [s]; minus infinity before.
    """

    def __init__(self, clock: Callable[[], float], silent_s: float = SILENT_S) -> None:
        """Nothing heard.

        Args:
            clock: monotonic [s].
            silent_s: least time without news that is silence [s].
        """
        self._clock = clock
        self._silent_s = silent_s
        self.at = -math.inf
        self._intervals: deque[float] = deque([0.0], maxlen=_INTERVALS)
        self._count = 0
        self._counted: deque[tuple[float, int]] = deque([(clock(), 0)])

    @property
    def age_s(self) -> float:
        """Time since then; infinite before [s]."""
        return self._clock() - self.at

    @property
    def patience_s(self) -> float:
        """Time without news that is silence: what comes seldom is waited for longer [s]."""
        return max(self._silent_s, SILENT_PERIODS * median(self._intervals))

    @property
    def silent(self) -> bool:
        """Whether news are overdue."""
        age_s = self.age_s
        return age_s > self._silent_s and age_s > self.patience_s

    @property
    def next_look_s(self) -> float:
        """Time in which no silence can begin that is not seen LOOK_S later, come what may [s]."""
        age_s = self.age_s
        if self.silent:
            return self._silent_s
        if age_s < self._silent_s:
            return self._silent_s - age_s
        return min(self.patience_s - age_s, LOOK_S)

    def figures(self) -> dict[str, str]:
        """Rate [Hz] and age [s], for diagnostics; to be asked several times in RATE_S."""
        now, counted = self._clock(), self._counted
        counted.append((now, self._count))
        while len(counted) > 2 and counted[1][0] <= now - RATE_S:
            counted.popleft()
        begin, before = counted[0]
        rate = (self._count - before) / (now - begin) if now > begin else 0.0
        age = "never" if self.at == -math.inf else f"{now - self.at:.3f}"
        return {"rate_hz": f"{rate:.1f}", "age_s": age}

    def note(self, count: int = 1, at: float | None = None) -> None:
        """Something has come, `count` of it at once; where not now, at a time of the clock [s]."""
        self._count += count
        came = self._clock() if at is None else at
        if self.at > -math.inf:
            self._intervals.append(came - self.at)
        self.at = came
