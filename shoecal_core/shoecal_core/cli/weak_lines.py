"""Directions that are not identified, for a terminal."""

from __future__ import annotations

import numpy as np

from shoecal_core.planning.supports.identifiability import Identifiability


def weak_lines(found: Identifiability) -> list[str]:
    """Directions that are not identified, each with what is known of it."""
    return [
        f"not identified: {weak.words} ("
        + ("no information in these data)" if np.isinf(weak.uncertainty) else
           f"uncertain by {100.0 * weak.uncertainty:.0f} %)")
        for weak in found.weak
    ]  # fmt: skip
