"""Smoothing and derivatives by local cubics (Savitzky and Golay, Analytical Chemistry 36, 1964).

What `scipy.signal.savgol_filter` gives; loading that takes as long as a whole calibration's fit.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import correlate1d

from shoecal_core.arrays import FloatArray

POWERS = np.arange(4)
SMOOTHING_S = 0.3
"""Window of the local cubic that accelerations are taken from."""


def acceleration_window(period: float) -> int:
    """Samples of that window, an odd number, for samples a period [s] apart."""
    return max(5, 2 * round(SMOOTHING_S / period / 2.0) + 1)


def local_cubics(values: FloatArray, window: int, period: float, order: int = 0) -> FloatArray:
    """(T, ...) of values (T, ...): in the middle of each window's cubic, its value or derivative.

    The first and the last half window are taken from the first and the last cubic.

    Args:
        values: of any unit, at even times.
        window: samples of each cubic, an odd number, T at most.
        period: from one sample to the next [s].
        order: of the derivative: per s to this power.
    """
    half = window // 2
    fit = _fit(window, period)
    found = np.asarray(correlate1d(values, _middle(fit, order), axis=0, mode="nearest"))
    # Of each power of time, the derivative's factor; lower powers are gone.
    factors = np.array([math.perm(int(power), order) for power in POWERS])
    times = period * np.arange(-half, half + 1)[:, None]
    basis = factors * times ** np.maximum(POWERS - order, 0)
    for here, edge in ((slice(half), slice(window)), (slice(-half, None), slice(-window, None))):
        found[here] = np.tensordot(basis[here] @ fit, values[edge], axes=1)
    return found


def middle_weights(window: int, period: float, order: int) -> FloatArray:
    """Weights (K,) of a window's K samples in what `local_cubics` gives in its middle."""
    return _middle(_fit(window, period), order)


def _fit(window: int, period: float) -> FloatArray:
    """(4, window) a cubic's coefficients about the window's middle, from its samples."""
    half = window // 2
    # In samples: powers of seconds would be of very different size.
    steps = np.arange(-half, half + 1)[:, None] ** POWERS.astype(float)
    found: FloatArray = np.linalg.pinv(steps) / period ** POWERS[:, None]
    return found


def _middle(fit: FloatArray, order: int) -> FloatArray:
    weights: FloatArray = math.factorial(order) * fit[order]
    return weights
