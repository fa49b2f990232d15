"""Stretches of time: marked samples put together, widened, and listed for a person."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray

Stretch = tuple[float, float]

JOIN_S = 1.0
"""Stretches no farther apart are reported as one [s]."""
MOST_TIMES = 3
"""So many stretches are named by their times; the others are counted."""


def stretches(mask: BoolArray, time: FloatArray, join_s: float = 0.0) -> tuple[Stretch, ...]:
    """First and last time of every stretch of marked samples, (T,) both.

    Args:
        join_s: stretches no farther apart than this are one [s].
    """
    marked = np.flatnonzero(mask)
    if not len(marked):
        return ()
    apart = (np.diff(marked) > 1) & (np.diff(time[marked]) > join_s)
    first = marked[np.concatenate(([True], apart))]
    last = marked[np.concatenate((apart, [True]))]
    return tuple((float(time[a]), float(time[b])) for a, b in zip(first, last, strict=True))


def widened(mask: BoolArray, time: FloatArray, margin_s: float) -> BoolArray:
    """(T,) marked samples and those within `margin_s` of one, by their times (T,) [s]."""
    wide = mask.copy()
    for start, end in stretches(mask, time):
        first = np.searchsorted(time, start - margin_s)
        wide[first : np.searchsorted(time, end + margin_s, side="right")] = True
    return wide


def lasting(mask: BoolArray, time: FloatArray, least_s: float) -> BoolArray:
    """(T,) marked samples of stretches that last at least `least_s`, by their times (T,) [s]."""
    long = np.zeros_like(mask)
    for start, end in stretches(mask, time):
        if end - start >= least_s:
            long |= mask & (time >= start) & (time <= end)
    return long


def unchanged(*values: IntArray) -> list[IntArray]:
    """Indices of each stretch in which none of the values (T,) changes."""
    change = np.flatnonzero(np.any([np.diff(one) != 0 for one in values], axis=0)) + 1
    return np.split(np.arange(len(values[0])), change)


def list_stretches(found: Sequence[Stretch]) -> str:
    """When it was, the longest stretches: `at 3.2 s, 7.0 to 8.5 s`; empty without any."""
    longest = sorted(found, key=lambda one: one[0] - one[1])[:MOST_TIMES]
    parts = [
        f"{start:.1f} s" if end - start < 0.05 else f"{start:.1f} to {end:.1f} s"
        for start, end in sorted(longest)
    ]
    if len(found) > MOST_TIMES:
        parts.append(f"{len(found) - MOST_TIMES} more times")
    return f"at {', '.join(parts)}" if parts else ""
