"""Filters on stamps that are not even: lags, plays, delays.

Stamps jitter, and samples get lost. A window or a derivative that counts samples is then of another
time than it seems to be: so values are resampled at even times first, and results brought back.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import uniform_filter1d

from shoecal_core.arrays import FloatArray

PACKETS_S = 0.2
"""Spans more than one packet of those that are read; gaps of a recording are few of such spans."""
SHORT = 0.5
"""A median step below that share of the mean one is that within a packet."""
EVEN = 0.01
"""Periods that differ by less than this share of one are even."""


def low_passed(values: FloatArray, time: FloatArray, constant: float) -> FloatArray:
    """First-order lag of values (F, k) with a time constant [s], settled at the start."""
    return evenly(lambda even, step: first_order(even, constant, step), values, time)


def first_order(values: FloatArray, constant: float, period: float) -> FloatArray:
    """The same lag of values (F, k) that are a period apart [s]."""
    # It takes as long to load as a whole fit, and most calls have no lag.
    from scipy.signal import lfilter  # noqa: PLC0415

    keep = np.exp(-period / constant)
    filtered, _ = lfilter([1.0 - keep], [1.0, -keep], values, axis=0, zi=keep * values[:1])
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


def typical_period(time: FloatArray) -> float:
    """Median time from one sample (T,) to the next; of samples that come in packets, on average
    over PACKETS_S [s].
    """
    steps = np.diff(time)
    step, mean = float(np.median(steps)), float(steps.mean())
    if step >= SHORT * mean:
        return step
    count = min(max(1, round(PACKETS_S / mean)), len(steps))
    average = float(np.median(time[count:] - time[:-count])) / count
    return step if step >= SHORT * average else average


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
    return made if even is time else at_times(made, even, time)


def resampled(values: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (K, ...) at even times, and these (K,) [s]; as they are where they are even."""
    period = typical_period(time)
    if is_even(time):
        return values, time
    even = np.arange(time[0], time[-1] + period / 2.0, period)
    return at_times(values, time, even), even


def is_even(time: FloatArray) -> bool:
    """Whether all periods of samples (T,) are alike."""
    period = typical_period(time)
    return bool(np.abs(np.diff(time) - period).max() <= EVEN * period)


def at_times(values: FloatArray, time: FloatArray, wanted: FloatArray) -> FloatArray:
    """(K, ...) of values (T, ...) between whose times is interpolated."""
    columns = values.reshape(len(values), -1).T
    found = np.stack([np.interp(wanted, time, column) for column in columns], axis=1)
    return found.reshape(len(wanted), *values.shape[1:])
