"""How much a channel's readings tremble, whatever converter they come from."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray

_MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal number."""


def spread(values: FloatArray) -> FloatArray:
    """(n,) standard deviation of most of the values (T, n): few outliers do not move it."""
    middle = np.median(values, axis=0)
    scale: FloatArray = np.median(np.abs(values - middle), axis=0) / _MEDIAN_OF_NORMAL
    return scale


def resolution(readings: FloatArray) -> FloatArray:
    """(n,) smallest step between two readings (T, n) in a row, in their unit; 0 without any."""
    steps = np.abs(np.diff(readings, axis=0))
    smallest = np.min(np.where(steps > 0.0, steps, np.inf), axis=0, initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)


def noise(readings: FloatArray) -> FloatArray:
    """(n,) standard deviation of one reading's noise, from second differences of (T, n).

    Slow motion hardly has any; a converter's step counts where the noise stays within it.
    """
    if len(readings) < 3:
        return np.zeros(readings.shape[1])
    second = np.abs(np.diff(readings, n=2, axis=0))
    trembling = np.median(second, axis=0) / (_MEDIAN_OF_NORMAL * np.sqrt(6.0))
    level: FloatArray = np.maximum(trembling, resolution(readings) / 2.0)
    return level
