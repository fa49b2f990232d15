"""How uncertain gains and offsets are that were fitted to a walk: noise and prior.

With H the Gauss-Newton Hessian of the fit, J and W Jacobian and weights of the samples, an error e
of measured against modelled GRF and CoP moves the parameters by -H^-1 J^T W e. Errors that pass
within the correlation time count with their covariance in time, taken from the residuals, so that
samples that err alike are not counted as many. What the data leave to the initial guess counts as
the prior has it. What the model of a walk has wrong is not known and is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.least_squares import Fit
from shoecal_core.calibration.residuals import Weights, errors, residuals
from shoecal_core.samples.stance import Stance

FloatArray = NDArray[np.float64]
BLOCK_S = 0.25
"""Residuals are averaged over so long: long against encoder steps, short against model errors."""


@dataclass(frozen=True)
class _Blocks:
    """One stance in T blocks, residuals in standard deviations.

    Attributes:
        weight: independent samples that one block counts for.
        step: length of a block [s].
        error: (3, T) mean residuals of GRF and CoP x, y.
        jacobian: (3, T, p).
    """

    weight: float
    step: float
    error: FloatArray
    jacobian: FloatArray


def walking_covariance(fit: Fit, stances: Sequence[Stance], weights: Weights) -> FloatArray:
    """(p, p) covariance of the p parameters of a fit.

    Args:
        fit: the minimum.
        stances: that it was fitted to.
        weights: that it was fitted with.
    """
    blocks = [_blocks(fit, stance, weights) for stance in stances]
    inverse = fit.covariance
    noise = inverse @ _noise_scores(blocks, fit, weights) @ inverse
    total = noise + inverse - inverse @ fit.information @ inverse
    covariance: FloatArray = 0.5 * (total + total.T)
    return covariance


def _blocks(fit: Fit, stance: Stance, weights: Weights) -> _Blocks:
    period = stance.duration / len(stance.time)
    samples = max(1, min(round(BLOCK_S / period), len(stance.time)))
    usable = len(stance.time) // samples * samples
    few = stance.part(slice(samples // 2, usable, samples))
    count = len(few.time)
    error = errors(fit.vector, stance, weights)
    _, jacobian = residuals(fit.vector, few, weights)
    kept = error.reshape(3, -1)[:, : samples * count]
    return _Blocks(
        weight=weights.of_sample(stance) * len(stance.time) / count,
        step=stance.duration / count,
        error=kept.reshape(3, count, samples).mean(axis=2),
        jacobian=jacobian.reshape(3, count, -1),
    )


def _noise_scores(blocks: Sequence[_Blocks], fit: Fit, weights: Weights) -> FloatArray:
    """(p, p) covariance of J^T W e for errors e that pass within the correlation time.

    Their covariance falls from the residuals' variance to zero at the correlation time, as the
    residuals' own covariance does above what lasts longer.
    """
    size = blocks[0].jacobian.shape[2]
    step = blocks[0].step
    lags = max(1, round(weights.correlation / step))
    total, pairs = np.zeros((3, lags + 1)), np.zeros(lags + 1)
    for one in blocks:
        count = one.error.shape[1]
        for lag in range(min(lags + 1, count)):
            total[:, lag] += (one.error[:, : count - lag] * one.error[:, lag:]).sum(axis=1)
            pairs[lag] += count - lag
    covariance = total / np.maximum(pairs, 1.0)
    independent = max(3.0 * pairs[0] * step / weights.correlation, fit.rank + 1.0)
    spent = independent / (independent - fit.rank)
    lasting = np.clip(covariance[:, -1:], 0.0, None)
    passing = spent * np.clip(covariance - lasting, 0.0, None)
    scores = np.zeros((size, size))
    for one in blocks:
        for axis in range(3):
            rows, count = one.jacobian[axis], one.error.shape[1]
            for lag in range(min(lags + 1, count)):
                part = rows[: count - lag].T @ rows[lag:]
                twice = part if lag == 0 else part + part.T
                scores += one.weight**2 * passing[axis, lag] * twice
    # A covariance in time that was estimated need not be one: nothing is less than certain.
    values, vectors = np.linalg.eigh(scores)
    certain: FloatArray = (vectors * np.clip(values, 0.0, None)) @ vectors.T
    return certain
