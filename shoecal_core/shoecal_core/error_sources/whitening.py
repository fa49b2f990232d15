"""Whitened signals, and the sums of their products.

Signals become cosine coefficients, a stance at a time (`spectrum`), each divided by the deviation
that its signal has in its band of frequency. The sums of products of all columns are made once;
every hypothesis, on whatever runs, is then a small system of equations for `Posterior`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources.spectrum import BandTransform
from shoecal_core.samples.samples import Samples


class Whitening:
    """Turns signals (..., T, s) into coefficients of unit noise.

    Args:
        samples: of the signals.
        mask: (T, s) signals that are there.
        noise: (s, BANDS) variance of a coefficient, by signal and band.
    """

    def __init__(self, samples: Samples, mask: BoolArray, noise: FloatArray) -> None:
        self.spectrum = BandTransform(samples, mask)
        std = np.sqrt(noise.ravel()[self.spectrum.group])
        self._scale = np.where(self.spectrum.kept, 1.0 / np.maximum(std, 1e-300), 0.0)
        self.kept = self.spectrum.kept
        self.run = samples.run

    def __call__(self, values: FloatArray) -> FloatArray:
        """(..., T, s) whitened; zero for coefficients that count for nothing."""
        whitened: FloatArray = self.spectrum(values) * self._scale
        return whitened


@dataclass(frozen=True)
class WhitenedProducts:
    """Products of whitened columns and of the residuals.

    The columns are the baseline's first, then those of hypotheses, then the residuals.

    Attributes:
        products: (q, q).
        base: number of the baseline's columns.
        precision: (base,) prior precision of the baseline's columns.
    """

    products: FloatArray
    base: int
    precision: FloatArray


def make_sums(
    whitening: Whitening,
    runs: Sequence[int],
    baseline: FloatArray,
    hypotheses: FloatArray,
    residuals: FloatArray,
    precision: FloatArray,
) -> WhitenedProducts:
    """Add up all products of some runs.

    Args:
        baseline: (p, T, s). hypotheses: (k, T, s). residuals: (T, s).
        precision: (p,) prior precision of the baseline's columns.
    """
    part = np.isin(whitening.run, runs)
    whitened = whitening(np.concatenate((baseline, hypotheses, residuals[None])))
    kept = whitening.kept[part]
    flat = whitened[:, part][:, kept]
    return WhitenedProducts(flat @ flat.T, len(baseline), precision)
