"""Do sensors that sent data when the motion began go on doing so?"""

from __future__ import annotations

import math
from collections.abc import Mapping

_NAMED = 3
"""Sources that are listed by name; of motors there may be two dozen."""


def silent(ages: Mapping[str, float], stale_s: float) -> str:
    """The sources that send nothing, and for how long, in a few words; empty when all do.

    Args:
        ages: by source, since when it has sent nothing [s].
        stale_s: for how long it may [s].
    """
    gone = [
        f"{name} ({age:.1f} s)" if math.isfinite(age) else name
        for name, age in ages.items()
        if age > stale_s
    ]
    more = len(gone) - _NAMED
    return ", ".join([*gone[:_NAMED], *([f"{more} more"] if more > 0 else [])])


class Silence:
    """Remembers which sources sent something at the start."""

    def __init__(self, ages: Mapping[str, float], stale_s: float) -> None:
        """A motion begins.

        Args:
            ages: by source, since when it has sent nothing; infinite where it never did [s].
            stale_s: for how long a source may send nothing [s].
        """
        self._stale_s = stale_s
        self._sources = tuple(name for name, age in ages.items() if age <= stale_s)

    def look(self, ages: Mapping[str, float]) -> str:
        """The sources that fell silent, and for how long; empty when all go on."""
        return silent({name: ages.get(name, math.inf) for name in self._sources}, self._stale_s)
