"""What memory does to a force in time: lags, plays, delays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from shoecal_core.samples.even import evenly

FloatArray = NDArray[np.float64]


def low_passed(values: FloatArray, time: FloatArray, constant: float) -> FloatArray:
    """First-order lag of values (F, k) with a time constant [s], settled at the start."""
    # It takes as long to load as a whole fit, and most calls have no lag.
    from scipy.signal import lfilter  # noqa: PLC0415

    def lagged(even: FloatArray, step: float) -> FloatArray:
        keep = np.exp(-step / constant)
        filtered, _ = lfilter([1.0 - keep], [1.0, -keep], even, axis=0, zi=keep * even[:1])
        return np.asarray(filtered)

    return evenly(lagged, values, time)


def play(values: FloatArray, width: FloatArray) -> FloatArray:
    """A play operator along (F, k): follows once pushed by half its width (k,)."""
    half = 0.5 * width
    followed = np.empty_like(values)
    state = values[0].copy()
    for index, value in enumerate(values):
        state = np.minimum(np.maximum(state, value - half), value + half)
        followed[index] = state
    return followed


def relay(values: FloatArray, band: float) -> FloatArray:
    """Side -1 or 1 to which values (F, k) last left a band about zero; 0 as long as none did."""
    side = np.where(np.abs(values) > band, np.sign(values), 0.0)
    last = np.where(side != 0.0, np.arange(len(side))[:, None], 0)
    held: FloatArray = np.take_along_axis(side, np.maximum.accumulate(last, axis=0), axis=0)
    return held


def slope(values: FloatArray, time: FloatArray, span: float = 0.6) -> FloatArray:
    """(F, k) rate of change, from how values differ half a span [s] before and after.

    What is fast, noise and the robot's own trembling, must not enter: it is in the residuals too
    and would pass for a delay.
    """

    def rate(even: FloatArray, step: float) -> FloatArray:
        width = 2 * round(span / 6.0 / step) + 1
        calm = uniform_filter1d(even, width, axis=0, mode="nearest")
        reach = max(1, round(span / 3.0 / step))
        index = np.arange(len(even))
        before, after = np.maximum(index - reach, 0), np.minimum(index + reach, len(even) - 1)
        gone = np.maximum(after - before, 1) * step
        return np.asarray((calm[after] - calm[before]) / gone[:, None])

    return evenly(rate, values, time)


def rise(rate: FloatArray, time: FloatArray, span: float) -> FloatArray:
    """(F, k) by how much what changes at a rate (F, k) is more a span [s] later, or at the end."""
    # As for a lag: most calls have no delay.
    from scipy.integrate import cumulative_trapezoid  # noqa: PLC0415

    whole = cumulative_trapezoid(rate, time, axis=0, initial=0)
    later = np.stack([np.interp(time + span, time, column) for column in whole.T], axis=1)
    found: FloatArray = later - whole
    return found
