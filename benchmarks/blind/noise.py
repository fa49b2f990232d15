"""Coloured noise of cells, of a drawn spectral slope."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray

CORNER_HZ = 0.3
"""Below it the colour is stronger than the white part."""
STEEPEST = 2.0
"""Slope of what wanders like a random walk."""


def coloured(
    shape: tuple[int, ...], rate: float, slope: float, rng: np.random.Generator
) -> FloatArray:
    """(T, n) noise of spectral density (1 + (CORNER_HZ / f)^2)^(slope / 2).

    Far above the corner it is white, of unit deviation a sample; its mean over the samples has
    the density of the lowest frequency.

    Args:
        shape: T, n. rate: samples a second [Hz].
        slope: 0: white; 1: flicker; 2: a random walk.
    """
    count = shape[0]
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    frequency[0] = frequency[1] if count > 1 else 1.0
    grown = (1.0 + (CORNER_HZ / frequency) ** 2) ** (slope / 4.0)
    spectrum = np.fft.rfft(rng.standard_normal(shape), axis=0)
    return np.asarray(np.fft.irfft(spectrum * grown[:, None], n=count, axis=0))
