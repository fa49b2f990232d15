"""Directions that data leave open, for a terminal."""

from __future__ import annotations

import numpy as np

from shoecal_core.planning.supports.identifiability import Identifiability


def weak_lines(found: Identifiability) -> list[str]:
    """Directions that stay open, each with what is known of it."""
    return [
        f"left open: {weak.words} ("
        + ("these data say nothing of it)" if np.isinf(weak.uncertainty) else
           f"uncertain by {100.0 * weak.uncertainty:.0f} %)")
        for weak in found.weak
    ]  # fmt: skip
