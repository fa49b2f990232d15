"""Filters that count samples, on stamps that are not even.

Stamps jitter, and samples get lost. A window or a derivative that counts samples is then of another
time than it seems to be: so values are resampled at even times first, and results brought back.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
EVEN = 0.01
"""Periods that differ by less than this share of one are even."""


def typical_period(time: FloatArray) -> float:
    """Median time from one sample (T,) to the next [s]."""
    return float(np.median(np.diff(time)))


def evenly(
    work: Callable[[FloatArray, float], FloatArray], values: FloatArray, time: FloatArray
) -> FloatArray:
    """What a filter makes of values (T, ...), at their own times (T,) [s].

    Args:
        work: from values (K, ...) at even times and their period [s] to as many results (K, ...).
        values, time: with stamps as they are.
    """
    placed, even = resampled(values, time)
    made = work(placed, typical_period(time))
    return made if even is time else _at(made, even, time)


def resampled(values: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (K, ...) at even times, and these (K,) [s]; as they are where they are even."""
    period = typical_period(time)
    if is_even(time):
        return values, time
    even = np.arange(time[0], time[-1] + period / 2.0, period)
    return _at(values, time, even), even


def is_even(time: FloatArray) -> bool:
    """Whether all periods of samples (T,) are alike."""
    period = typical_period(time)
    return bool(np.abs(np.diff(time) - period).max() <= EVEN * period)


def _at(values: FloatArray, time: FloatArray, wanted: FloatArray) -> FloatArray:
    """(K, ...) of values (T, ...) between whose times is interpolated."""
    columns = values.reshape(len(values), -1).T
    found = np.stack([np.interp(wanted, time, column) for column in columns], axis=1)
    return found.reshape(len(wanted), *values.shape[1:])
