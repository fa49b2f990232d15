"""Least squares over the signals, from sums that every hypothesis shares.

All signals are whitened: each is one noise, correlated from sample to sample, long. The sums of
products of all columns, a run at a time, are made once; every hypothesis, on whatever runs, is
then a small system of equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.samples.samples import Samples

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

FEW_RUNS, STRETCHES = 4, 4
"""Of fewer training runs than the first, stretches are left out: each run is cut into the second.

Without one of a few double supports a fit loses rank, and what it foretells says nothing."""


@dataclass(frozen=True)
class Noise:
    """Noise of the signals, s of them: x_t = keep x_{t-1} + innovation.

    Attributes:
        std: (s,) of the noise itself.
        keep: (s,) correlation from one sample to the next.
    """

    std: FloatArray
    keep: FloatArray

    @property
    def innovation(self) -> FloatArray:
        """(s,) standard deviation of what is new in each sample."""
        return self.std * np.sqrt(1.0 - self.keep**2)


class Whitening:
    """Turns signals (..., T, s) into rows of unit noise.

    Args:
        samples: which follow each other within a run and segment.
        mask: (T, s) signals that are there.
        noise: of the signals.
    """

    def __init__(self, samples: Samples, mask: BoolArray, noise: Noise) -> None:
        step = np.diff(samples.time)
        usual = float(np.median(step))
        follows = (np.diff(samples.segment) == 0) & (step > 0.0) & (step < 1.5 * usual)
        self._follows = np.concatenate(([False], follows))[:, None] & mask
        self._follows[1:] &= mask[:-1]
        self._keep = np.where(self._follows, noise.keep, 0.0)
        first = np.sqrt(1.0 - noise.keep**2)
        scale = np.where(self._follows, 1.0, first) / np.maximum(noise.innovation, 1e-300)
        self._scale = np.where(mask, scale, 0.0)
        self.run = samples.run
        self.stretch = stretches_of(samples)

    def __call__(self, values: FloatArray) -> FloatArray:
        """(..., T, s) whitened."""
        whitened = values.copy()
        whitened[..., 1:, :] -= self._keep[1:] * values[..., :-1, :]
        whitened *= self._scale
        return whitened


def stretches_of(samples: Samples) -> IntArray:
    """(T,) which of the stretches of its run each sample is of, alike in length."""
    found = np.zeros(len(samples.run), dtype=np.int64)
    for run in np.unique(samples.run):
        here = np.flatnonzero(samples.run == run)
        found[here] = np.arange(len(here)) * STRETCHES // len(here)
    return found


@dataclass(frozen=True)
class Sums:
    """Products of whitened columns and of the residuals, by stretches of runs.

    The columns are the baseline's first, then those of hypotheses, then the residuals.

    Attributes:
        runs: (B,) number of the run of which each stretch is.
        products: (B, q, q).
        rows: (B,) number of whitened rows.
        base: number of the baseline's columns.
        precision: (base,) prior precision of the baseline's columns.
    """

    runs: tuple[int, ...]
    products: FloatArray
    rows: FloatArray
    base: int
    precision: FloatArray

    def of(self, runs: Sequence[int]) -> tuple[FloatArray, float]:
        """Products and number of rows of some runs together."""
        part = np.isin(self.runs, runs)
        return self.products[part].sum(axis=0), float(self.rows[part].sum())

    def others(self, runs: Sequence[int]) -> list[FloatArray]:
        """Products of some runs without one of their stretches, each in turn."""
        mine = np.isin(self.runs, runs)
        return [
            self.products[mine & (np.arange(len(mine)) != left_out)].sum(axis=0)
            for left_out in np.flatnonzero(mine)
        ]


def make_sums(
    whitening: Whitening,
    runs: Sequence[int],
    baseline: FloatArray,
    hypotheses: FloatArray,
    residuals: FloatArray,
    mask: BoolArray,
    precision: FloatArray,
    *,
    cut: bool = False,
) -> Sums:
    """Add up all products.

    Args:
        baseline: (p, T, s). hypotheses: (k, T, s). residuals: (T, s).
        mask: (T, s) signals that are there.
        precision: (p,) prior precision of the baseline's columns.
        cut: runs into stretches.
    """
    whole = np.concatenate((baseline, hypotheses, residuals[None]))
    size = len(whole)
    stretches = [(run, at) for run in runs for at in range(STRETCHES if cut else 1)]
    products = np.zeros((len(stretches), size, size))
    rows = np.zeros(len(stretches))
    whitened = whitening(whole)
    for index, (run, stretch) in enumerate(stretches):
        part = whitening.run == run
        if cut:
            part &= whitening.stretch == stretch
        flat = whitened[:, part][:, mask[part]]
        products[index] = flat @ flat.T
        rows[index] = mask[part].sum()
    return Sums(tuple(run for run, _ in stretches), products, rows, len(baseline), precision)


@dataclass(frozen=True)
class Solution:
    """A fit of the baseline and some more columns.

    Attributes:
        vector: (p + k,) what the columns are to be taken times to give the residuals.
        covariance: (p + k, p + k) under unit noise.
        squares: weighted sum of squares left, priors included.
        log_volume: half the logarithm of how much the data narrow the k columns' priors.
    """

    vector: FloatArray
    covariance: FloatArray
    squares: float
    log_volume: float


def solve(products: FloatArray, sums: Sums, columns: Sequence[int], std: FloatArray) -> Solution:
    """Least squares with priors.

    Args:
        products: (q, q) of the runs to fit.
        columns: of hypotheses, counted from the first of them.
        std: (k,) prior standard deviation of each.
    """
    chosen = np.concatenate((np.arange(sums.base), sums.base + np.asarray(columns, dtype=np.int64)))
    precision = np.concatenate((sums.precision, 1.0 / std**2))
    normal = products[np.ix_(chosen, chosen)]
    right = products[chosen, -1]
    scale = 1.0 / np.sqrt(np.diag(normal) + precision)
    system = (normal + np.diag(precision)) * np.outer(scale, scale)
    factor = np.linalg.cholesky(system + 1e-12 * np.eye(len(system)))
    inverse = np.linalg.inv(factor)
    covariance = (inverse.T @ inverse) * np.outer(scale, scale)
    vector = covariance @ right
    squares = float(products[-1, -1] - right @ vector)
    k = len(std)
    volume = 0.0
    if k:
        tail = covariance[-k:, -k:] / np.outer(std, std)
        volume = -0.5 * float(np.linalg.slogdet(tail)[1])
    return Solution(vector, covariance, squares, volume)
