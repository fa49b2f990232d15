"""How uncertain fitted gains and offsets are: noise, prior, and a model that is not quite right.

With H the Gauss-Newton Hessian of the fit, J and W Jacobian and weights of the samples, an error e
of measured against modelled GRF and CoP moves the parameters by -H^-1 J^T W e. Three kinds count:
  noise      errors that pass within the correlation time; their covariance in time is taken from
             the residuals, so that samples that err alike are not counted as many;
  model      tolerances t of robot and shoes (`tolerances`), alike in all runs: e = B t;
  prior      what the data leave to the initial guess.

Tolerances are made to agree with the residuals: each one's variance is scaled by
1 / (1 + mu v), v its visible part (what no parameter can swallow), with mu such that together they
show as much as the residuals do that last beyond the correlation time. This departs least from the
stated tolerances (least relative entropy of their normal laws under that one condition).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.optimize import brentq

from shoecal_core.calibration.least_squares import Fit
from shoecal_core.calibration.residuals import Weights, errors, residuals, unpack
from shoecal_core.calibration.tolerances import ModelTolerances
from shoecal_core.samples.stance import Stance

FloatArray = NDArray[np.float64]
BLOCK_S = 0.25
"""Residuals are averaged over so long: long against encoder steps, short against model errors."""
LEAST_SHOWN = 0.01
"""Residuals never show less than this share of the tolerances: some error is always left."""
ONE_SIDED_MEAN = np.sqrt(2.0 / np.pi)
"""Mean size of a normal error of unit standard deviation."""


@dataclass(frozen=True)
class Uncertainty:
    """Covariance of p fitted parameters, and where it comes from.

    Attributes:
        noise, model, prior: (p, p) its three parts.
        causes: names of the q tolerances; none where the model's part was left out.
        slopes: (p, q) how far each tolerance, one standard deviation long, moves the parameters.
        agreed: (q, q) second moments of the tolerances, in those units, as the residuals allow.
        placing: (3, q) what each of them misplaces the right foot by: see `tolerances.Effects`.
    """

    noise: FloatArray
    model: FloatArray
    prior: FloatArray
    causes: tuple[str, ...]
    slopes: FloatArray
    agreed: FloatArray
    placing: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """(p, p) all three parts."""
        total = self.noise + self.model + self.prior
        return 0.5 * (total + total.T)


@dataclass(frozen=True)
class _Blocks:
    """One stance in T blocks, residuals in standard deviations.

    Attributes:
        weight: independent samples that one block counts for.
        step: length of a block [s].
        error: (3, T) mean residuals of GRF and CoP x, y.
        jacobian: (3, T, p).
        effects: (3, T, q) what each tolerance adds.
    """

    weight: float
    step: float
    error: FloatArray
    jacobian: FloatArray
    effects: FloatArray


def estimate_uncertainty(
    fit: Fit,
    stances: Sequence[Stance],
    weights: Weights,
    tolerances: ModelTolerances | None,
) -> Uncertainty:
    """Uncertainty of a fit.

    Args:
        fit: the minimum.
        stances: that it was fitted to; one of a walk or without joint angles leaves the model's
            part out.
        weights: that it was fitted with.
        tolerances: of the model; None leaves its part out.
    """
    told = all(stance.angles is not None for stance in stances)
    walked = any(stance.hanging is not None and not stance.quasi_static for stance in stances)
    carried = tolerances if told and not walked else None
    causes: tuple[str, ...] = ()
    one_sided = np.zeros(0, dtype=bool)
    blocks, placings = [], []
    for stance in stances:
        few = _centres(stance)
        effects = np.zeros((3, len(few.time), 0))
        if carried is not None:
            found = carried.effects(few, unpack(fit.vector)[0])
            causes, one_sided = found.causes, found.one_sided
            if stance.hanging is None:
                placings.append(found.placing)
            effects = np.stack(
                [found.force / weights.force, *(np.moveaxis(found.cop, 1, 0) / weights.cop)]
            )
        blocks.append(_blocks(fit, stance, few, effects, weights))
    inverse = fit.covariance
    moved = sum(one.weight * np.einsum("ctp,ctq->pq", one.jacobian, one.effects) for one in blocks)
    slopes: FloatArray = -inverse @ moved
    agreed = _agreed(blocks, slopes, one_sided, weights)
    noise = inverse @ _noise_scores(blocks, fit, weights) @ inverse
    return Uncertainty(
        noise=noise,
        model=slopes @ agreed @ slopes.T,
        prior=inverse - inverse @ fit.information @ inverse,
        causes=causes,
        slopes=slopes,
        agreed=agreed,
        placing=np.mean(placings, axis=0) if placings else np.zeros((3, 0)),
    )


def _samples_a_block(stance: Stance) -> int:
    period = stance.duration / len(stance.time)
    return max(1, min(round(BLOCK_S / period), len(stance.time)))


def _centres(stance: Stance) -> Stance:
    """One sample a block."""
    samples = _samples_a_block(stance)
    usable = len(stance.time) // samples * samples
    return stance.part(slice(samples // 2, usable, samples))


def _blocks(
    fit: Fit, stance: Stance, few: Stance, effects: FloatArray, weights: Weights
) -> _Blocks:
    samples, count = _samples_a_block(stance), len(few.time)
    error = errors(fit.vector, stance, weights)
    _, jacobian = residuals(fit.vector, few, weights)
    kept = error.reshape(3, -1)[:, : samples * count]
    return _Blocks(
        weight=weights.of_sample(stance) * len(stance.time) / count,
        step=stance.duration / count,
        error=kept.reshape(3, count, samples).mean(axis=2),
        jacobian=jacobian.reshape(3, count, -1),
        effects=effects,
    )


def _agreed(
    blocks: Sequence[_Blocks],
    slopes: FloatArray,
    one_sided: NDArray[np.bool_],
    weights: Weights,
) -> FloatArray:
    """(q, q) second moments of the tolerances, as far as the residuals allow them.

    Both are looked at as means over the correlation time: what passes faster is noise.
    """
    stated = _second_moments(one_sided)
    shown, seen = np.zeros_like(stated), 0.0
    for one in blocks:
        span = max(1, round(weights.correlation / one.step))
        left = uniform_filter1d(one.effects + one.jacobian @ slopes, span, axis=1)
        shown += np.einsum("ctq,ctr->qr", left, left)
        seen += float((uniform_filter1d(one.error, span, axis=1) ** 2).sum())
    values, vectors = np.linalg.eigh(stated)
    root = vectors * np.sqrt(np.clip(values, 0.0, None))
    visible, directions = np.linalg.eigh(root.T @ shown @ root)
    visible = np.clip(visible, 0.0, None)
    kept = _kept(visible, seen)
    axes = root @ directions
    agreed: FloatArray = (axes * kept) @ axes.T
    return agreed


def _kept(visible: FloatArray, seen: float) -> FloatArray:
    """Share of each direction's variance: 1 / (1 + mu v) with sum v / (1 + mu v) as seen."""
    total = float(visible.sum())
    if not total > 0.0:
        return np.ones_like(visible)
    target = max(seen, LEAST_SHOWN * total)
    # Between these two the sum falls from far above the target to below it.
    lowest = -(1.0 - min(1.0, 0.5 * float(visible.max()) / target)) / float(visible.max())
    highest = len(visible) / target
    mu = brentq(lambda mu: float((visible / (1.0 + mu * visible)).sum()) - target, lowest, highest)
    kept: FloatArray = 1.0 / (1.0 + mu * visible)
    return kept


def _second_moments(one_sided: NDArray[np.bool_]) -> FloatArray:
    """(q, q) as stated: one-sided causes have a mean, so they do not cancel at random."""
    mean = ONE_SIDED_MEAN * one_sided
    moments: FloatArray = np.outer(mean, mean)
    np.fill_diagonal(moments, 1.0)
    return moments


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
