"""Gains and offsets together with everything that the model may have wrong.

The residuals are those of a calibration (`calibration.residuals`), over means of short stretches of
time; unknowns of the body shift the modelled CoP, those of the shoes the channels' columns:
    r_F = (F - F_m) / s_F,  r_C = (C - C_m - sum_k B_k u_k) / s_C,  A_i = A_i0 + sum_k D_ik u_k.
Each unknown has its prior. What comes of it is a corrected shoe and a corrected reference, on which
an ordinary calibration then finds the same gains and offsets, and how sure they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.fit import prior_of
from shoecal_core.calibration.initial_guess import initial_guess
from shoecal_core.calibration.least_squares import Fit, Prior, minimise
from shoecal_core.calibration.refinement.reference import Reference, extra_force
from shoecal_core.calibration.refinement.unknowns import MEASURING, Unknown, column_change
from shoecal_core.calibration.residuals import Normal, Weights, hanging_weights
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, to_left, weight_below

FloatArray = NDArray[np.float64]

STRETCH_S = 0.25
"""Residuals are averaged over so long."""
TOLERANCE = 1e-6
"""Share of the cost; where a further step promises to save less, it ends."""


@dataclass(frozen=True)
class Fitted:
    """An unknown as it was fitted: what was believed, its value and standard deviation."""

    unknown: Unknown
    value: float
    std: float


@dataclass(frozen=True)
class Evidence:
    """How probable the readings are with some unknowns, whatever their sizes.

    Attributes:
        log: natural logarithm, less what is the same for all unknowns (Laplace's approximation:
            MacKay, Neural Computation 4, 1992: 415-447).
        misfit: sum of squares over the number of independent residuals: about 1, if models are
            off by as much as the settings say.
    """

    log: float
    misfit: float


@dataclass(frozen=True)
class Refinement:
    """A corrected shoe, and how the reference is corrected.

    Attributes:
        shoe: with the fitted columns.
        fitted: every unknown.
        correct: gives a stance the corrected reference, and the columns of that shoe.
        evidence: for just these unknowns.
    """

    shoe: Shoe
    fitted: tuple[Fitted, ...]
    correct: Callable[[Stance], Stance]
    evidence: Evidence


def refine(
    shoe: Shoe,
    stances: Sequence[Stance],
    reference: Reference,
    unknowns: Sequence[Unknown],
    settings: CalibrationSettings,
) -> Refinement:
    """Fit gains, offsets and unknowns to quasi-static stances.

    Args:
        shoe: as its file says.
        stances: to fit, with joint angles (and efforts where gears are unknown).
        reference: of the robot.
        unknowns: with what is believed of them.
        settings: weights.

    Raises:
        ShoecalError: when it does not settle.
    """
    body = [one for one in unknowns if one.effect not in MEASURING]
    shoes = [one for one in unknowns if one.effect in MEASURING]
    changes = np.array([column_change(one, shoe) for one in shoes])
    changes = changes.reshape(len(shoes), len(shoe.names), 3)
    weights = Weights.of(settings)
    terms = [
        term
        for stance in stances
        for term in _terms(stance, shoe, reference, body, changes, weights)
    ]
    guess = prior_of(shoe, initial_guess(shoe, stances, weight_row=False), settings)
    count = len(shoe.names)
    prior = Prior(
        np.concatenate((guess.mean[: 2 * count], [one.mean for one in (*body, *shoes)])),
        np.concatenate((guess.std[: 2 * count], [one.std for one in (*body, *shoes)])),
    )

    def normal(vector: FloatArray) -> Normal:
        size = len(vector)
        total = Normal(0.0, np.zeros(size), np.zeros((size, size)))
        for term in terms:
            total += term.normal(vector, len(body))
        return total

    fit = minimise(normal, prior, max_iterations=settings.max_iterations, tolerance=TOLERANCE)
    found = fit.vector[2 * count :]
    corrected = shoe.with_columns(shoe.columns + np.tensordot(found[len(body) :], changes, axes=1))
    sizes = found[: len(body)]

    def correct(stance: Stance) -> Stance:
        return _corrected(stance, corrected, reference, body, sizes)

    fitted = _fitted((*body, *shoes), fit, 2 * count)
    return Refinement(corrected, fitted, correct, _evidence(fit, terms))


def _fitted(unknowns: Sequence[Unknown], fit: Fit, first: int) -> tuple[Fitted, ...]:
    stds = np.sqrt(np.diag(fit.covariance))[first:]
    return tuple(
        Fitted(unknown, float(value), float(std))
        for unknown, value, std in zip(unknowns, fit.vector[first:], stds, strict=True)
    )


def _evidence(fit: Fit, terms: Sequence[_Term]) -> Evidence:
    independent = sum(3.0 * term.share * len(term.readings) for term in terms)
    volume = float(np.log1p(fit.singular_values**2).sum())
    return Evidence(-0.5 * (fit.cost + volume), fit.cost / max(independent, 1.0))


@dataclass(frozen=True)
class _Term:
    """Residuals of T means of one stance, of what is loaded or of a foot in the air.

    Attributes:
        readings: (T, n).
        target: (T, 3) force [N] and CoP [m] that the model expects; None for a foot in the air.
        shifts: (T, 3, b) of them, a unit of each unknown of the body.
        columns: (n, 3). changes: (s, n, 3) of them, a unit of each unknown of the shoes.
        base: (3,) wrench of the parts below.
        std: (3,) of force and CoP, or of the three parts of the wrench.
        share: how much of an independent sample each mean counts for.
    """

    readings: FloatArray
    target: FloatArray | None
    shifts: FloatArray
    columns: FloatArray
    changes: FloatArray
    base: FloatArray
    std: FloatArray
    share: float

    def normal(self, vector: FloatArray, body: int) -> Normal:
        """Gauss-Newton model of gains, offsets, unknowns of the body, unknowns of the shoes."""
        count = self.readings.shape[1]
        parameters = ChannelParameters(vector[:count], vector[count : 2 * count])
        moved, turned = np.split(vector[2 * count :], [body])
        columns = self.columns + np.tensordot(turned, self.changes, axes=1)
        outputs = parameters.outputs(self.readings)
        wrench = outputs @ columns + self.base
        # By gains, offsets and the shoes' unknowns: (T, 3, 2n + s) of the wrench.
        by_offset = np.broadcast_to(columns.T, (len(outputs), *columns.T.shape))
        by_shoe = np.einsum("tn,snk->tks", outputs, self.changes)
        slopes = np.concatenate((by_offset * self.readings[:, None, :], by_offset, by_shoe), axis=2)
        rest = wrench
        if self.target is not None:
            force = wrench[:, 0]
            place = np.stack((-wrench[:, 2], wrench[:, 1]), axis=1) / force[:, None]
            by_place = np.stack((-slopes[:, 2], slopes[:, 1]), axis=1)
            by_place = (by_place - place[:, :, None] * slopes[:, :1]) / force[:, None, None]
            slopes = np.concatenate((slopes[:, :1], by_place), axis=1)
            rest = np.column_stack((force, place)) - self.target - self.shifts @ moved
        jacobian = np.concatenate(
            (slopes[:, :, : 2 * count], -self.shifts, slopes[:, :, 2 * count :]), axis=2
        )
        jacobian = (jacobian / self.std[:, None]).reshape(-1, len(vector))
        rest = (rest / self.std).reshape(-1)
        return Normal(
            self.share * float(rest @ rest),
            self.share * (jacobian.T @ rest),
            self.share * (jacobian.T @ jacobian),
        )


def _terms(
    stance: Stance,
    shoe: Shoe,
    reference: Reference,
    body: Sequence[Unknown],
    changes: FloatArray,
    weights: Weights,
) -> list[_Term]:
    means = _means(stance)
    if means is None:
        return []
    count = len(means.time)
    share = weights.of_sample(stance) * len(stance.time) / count
    shifts = np.zeros((count, 3, len(body)))
    shifts[:, 0] = [extra_force(one) for one in body]
    shifts[:, 1:] = reference.shifts(means, body)
    loaded = _Term(
        readings=means.readings,
        target=np.column_stack((means.force, means.cop)),
        shifts=shifts,
        columns=means.columns,
        changes=_in_stance(changes, means, shoe),
        base=means.base,
        std=np.array([weights.force, weights.cop, weights.cop]),
        share=share,
    )
    foot = stance.hanging
    if foot is None:
        return [loaded]
    own = (shoe.foot == foot)[:, None]
    weight = float(stance.force.mean())
    tight = hanging_weights(stance, weights)
    moment = tight.cop * weight
    hanging = replace(
        loaded,
        target=None,
        shifts=np.zeros_like(shifts),
        columns=np.where(own, shoe.columns, 0.0),
        changes=np.where(own, changes, 0.0),
        base=weight_below(shoe)[foot],
        std=np.array([tight.force, moment, moment]),
    )
    return [loaded, hanging]


def _in_stance(changes: FloatArray, stance: Stance, shoe: Shoe) -> FloatArray:
    """Changes (s, n, 3) of columns in the stance's frame; none of a foot in the air."""
    if stance.hanging is not None:
        return np.where((shoe.foot == stance.hanging)[:, None], 0.0, changes)
    turned = changes.copy()
    right = shoe.of_foot(1)
    turned[:, right] = changes[:, right] @ to_left(stance.support).T
    return turned


def _means(stance: Stance) -> Stance | None:
    """Means over short stretches; None of a stance that is shorter than one."""
    if not len(stance.time):
        return None
    samples = max(1, round(STRETCH_S * len(stance.time) / max(stance.duration, 1e-9)))
    count = len(stance.time) // samples
    if count == 0:
        return None

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(
            values[: count * samples].reshape(count, samples, *values.shape[1:]).mean(axis=1)
        )

    return replace(
        stance,
        time=mean(stance.time),
        readings=mean(stance.readings),
        force=mean(stance.force),
        cop=mean(stance.cop),
        cop_rate=mean(stance.cop_rate),
        angles=None if stance.angles is None else mean(stance.angles),
        efforts=None if stance.efforts is None else mean(stance.efforts),
    )


def _corrected(
    stance: Stance, shoe: Shoe, reference: Reference, body: Sequence[Unknown], sizes: FloatArray
) -> Stance:
    """The stance with the reference that these sizes make, and with the shoe's columns."""
    turned = _in_stance(shoe.columns[None], stance, shoe)[0]
    means = _means(stance)
    if means is None:
        return replace(stance, columns=turned)
    shift = reference.shifts(means, body) @ sizes
    place = np.stack([np.interp(stance.time, means.time, axis) for axis in shift.T], axis=1)
    force = float(np.dot([extra_force(one) for one in body], sizes)) if body else 0.0
    return replace(stance, cop=stance.cop + place, force=stance.force + force, columns=turned)
