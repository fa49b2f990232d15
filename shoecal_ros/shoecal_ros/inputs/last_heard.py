"""Since when an input has told nothing."""

from __future__ import annotations

import math
from collections.abc import Callable


class LastHeard:
    """When something usable last came, by the wall clock."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Nothing heard.

        Args:
            clock: monotonic [s].
        """
        self._clock = clock
        self._at = -math.inf

    @property
    def age_s(self) -> float:
        """Time since then; infinite before [s]."""
        return self._clock() - self._at

    def note(self) -> None:
        """Something has come."""
        self._at = self._clock()
