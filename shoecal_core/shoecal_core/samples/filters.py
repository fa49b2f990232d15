"""What memory does to a force in time: lags, plays, delays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

FloatArray = NDArray[np.float64]


def low_passed(values: FloatArray, time: FloatArray, constant: float) -> FloatArray:
    """First-order lag of values (F, k) with a time constant [s], settled at the start."""
    step = float(np.median(np.diff(time)))
    keep = np.exp(-step / constant)
    start = keep * values[:1]
    filtered, _ = lfilter([1.0 - keep], [1.0, -keep], values, axis=0, zi=start)
    return np.asarray(filtered)


def play(values: FloatArray, width: FloatArray) -> FloatArray:
    """A play operator along (F, k): follows once pushed by half its width (k,)."""
    half = 0.5 * width
    followed = np.empty_like(values)
    state = values[0].copy()
    for index, value in enumerate(values):
        state = np.minimum(np.maximum(state, value - half), value + half)
        followed[index] = state
    return followed


def slope(values: FloatArray, time: FloatArray, span: float = 0.6) -> FloatArray:
    """(F, k) rate of change, from how values differ half a span [s] before and after.

    What is fast, noise and the robot's own trembling, must not enter: it is in the residuals too
    and would pass for a delay.
    """
    step = float(np.median(np.diff(time)))
    width = 2 * round(span / 6.0 / step) + 1
    calm = uniform_filter1d(values, width, axis=0, mode="nearest")
    reach = max(1, round(span / 3.0 / step))
    index = np.arange(len(time))
    before, after = np.maximum(index - reach, 0), np.minimum(index + reach, len(time) - 1)
    gone = np.maximum(time[after] - time[before], step)
    rate: FloatArray = (calm[after] - calm[before]) / gone[:, None]
    return rate
