"""Signals by frequency: cosine coefficients of each stance, in bands.

Model errors are correlated over seconds, sensor noise is not, so that what counts as small depends
on the frequency. A discrete cosine transform (type II, orthonormal) of each stance makes
coefficients that are nearly independent whatever the noise's spectrum is.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import dct

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.error_sources.signals import GRF
from shoecal_core.samples.samples import Samples

EDGES_HZ = (0.0, 0.04, 0.08, 0.16, 0.32, 0.64, 1.0)
"""Of the bands; faster than the last nothing but noise moves in a robot that stands."""
BANDS = len(EDGES_HZ) - 1
MIDDLE_HZ = np.array([0.03, 0.06, 0.11, 0.23, 0.45, 0.8])
GRF_BANDS = 4
"""The force hardly changes while a robot stands: what is faster would only make gains that
lessen its noise look right."""
FEWEST = 2


class BandTransform:
    """The transform, laid out like the signals.

    Args:
        samples: T of them. mask: (T, s) signals that are there.

    Attributes:
        kept: (T, s) coefficients that count.
        group: (T, s) of each, its signal times BANDS plus its band.
    """

    def __init__(self, samples: Samples, mask: BoolArray) -> None:
        count, signals = mask.shape
        self._mask = mask
        self.kept = np.zeros((count, signals), dtype=np.bool_)
        self.group = np.zeros((count, signals), dtype=np.int64)
        # Signals that are there in the same samples of a segment are transformed together.
        self.parts: list[tuple[IntArray, IntArray]] = []
        for segment in np.unique(samples.segment):
            here = np.flatnonzero(samples.segment == segment)
            patterns, of = np.unique(mask[here], axis=1, return_inverse=True)
            of = of.reshape(-1)
            for index in range(patterns.shape[1]):
                rows = here[patterns[:, index]]
                own = np.flatnonzero(of == index)
                if len(rows) < FEWEST:
                    continue
                self.parts.append((rows, own))
                step = float(np.median(np.diff(samples.time[rows])))
                frequency = np.arange(len(rows)) / (2.0 * len(rows) * step)
                band = np.searchsorted(EDGES_HZ, frequency, side="right") - 1
                self.kept[np.ix_(rows, own)] = (band < BANDS)[:, None]
                self.group[np.ix_(rows, own)] = own * BANDS + np.minimum(band, BANDS - 1)[:, None]
        self.kept[:, GRF] &= self.group[:, GRF] % BANDS < GRF_BANDS

    def __call__(self, values: FloatArray) -> FloatArray:
        """(..., T, s) coefficients of signals (..., T, s); zero where nothing is there."""
        found = np.zeros_like(values)
        for rows, own in self.parts:
            part = np.ix_(rows, own)
            found[..., part[0], part[1]] = dct(values[..., part[0], part[1]], axis=-2, norm="ortho")
        return found


def signals_of(groups: IntArray) -> IntArray:
    """(G,) index of the signal of each group."""
    return groups // BANDS


def frequencies_of(groups: IntArray) -> FloatArray:
    """(G,) middle of each group's band [Hz]."""
    return MIDDLE_HZ[groups % BANDS]
