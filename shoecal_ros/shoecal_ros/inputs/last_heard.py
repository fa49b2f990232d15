"""Since when an input has told nothing."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from statistics import median

SILENT_S = 0.08
"""Without news for so long an input may be silent: told within 0.1 s, what it takes included."""
SILENT_PERIODS = 2.7
"""Where it comes more seldom, without news for so many of its periods: told within three."""
_INTERVALS = 9


class LastHeard:
    """When something usable last came, by the wall clock."""

    def __init__(self, clock: Callable[[], float], silent_s: float = SILENT_S) -> None:
        """Nothing heard.

        Args:
            clock: monotonic [s].
            silent_s: least time without news that is silence [s].
        """
        self._clock = clock
        self._silent_s = silent_s
        self._at = -math.inf
        self._intervals: deque[float] = deque([0.0], maxlen=_INTERVALS)

    @property
    def age_s(self) -> float:
        """Time since then; infinite before [s]."""
        return self._clock() - self._at

    @property
    def patience_s(self) -> float:
        """Time without news that is silence: what comes seldom is waited for longer [s]."""
        return max(self._silent_s, SILENT_PERIODS * median(self._intervals))

    @property
    def silent(self) -> bool:
        """Whether news are overdue."""
        age_s = self.age_s
        return age_s > self._silent_s and age_s > self.patience_s

    def note(self) -> None:
        """Something has come."""
        now = self._clock()
        if self._at > -math.inf:
            self._intervals.append(now - self._at)
        self._at = now
