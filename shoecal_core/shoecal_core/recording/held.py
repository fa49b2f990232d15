"""Readings that a board holds: it sends the last ones again, all channels alike to the last bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST_NS = 100_000_000
"""Readings that stay for less may do so by chance [ns]."""
NOISY_STEPS = 4.0
"""Usual change from reading to reading, over the least there is, of a channel that trembles."""
TREMBLING = 2
"""Channels that must tremble: readings of coarse converters stay where they are while nothing
moves."""


def held(stamp_ns: NDArray[np.int64], values: Floats) -> NDArray[np.bool_]:
    """(T,) mask of readings of one source (T, k) that are its last ones sent again."""
    steps = np.abs(np.diff(values, axis=0))
    if not len(steps) or sum(map(_trembles, steps.T)) < min(TREMBLING, values.shape[1]):
        return np.zeros(len(values), dtype=bool)
    same = np.concatenate(([False], (steps == 0.0).all(axis=1)))
    # Each stretch from the reading that is sent again to the last that is the same.
    starts = np.flatnonzero(same & ~np.roll(same, 1)) - 1
    ends = np.flatnonzero(same & ~np.append(same[1:], False))
    for start, end in zip(starts, ends, strict=True):
        if stamp_ns[end] - stamp_ns[start] < LEAST_NS:
            same[start : end + 1] = False
    return same


def _trembles(steps: Floats) -> bool:
    """Whether a channel's readings differ by many steps of its converter, as a rule."""
    moved = steps[steps > 0.0]
    return bool(len(moved)) and float(np.median(moved)) >= NOISY_STEPS * float(moved.min())
