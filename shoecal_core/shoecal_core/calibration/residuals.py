"""Residuals of measured GRF and CoP against the model, and their derivatives (paper, eq. 18).

The parameter vector, in this order everywhere: n gains, n offsets, the time offset.
A sample's residuals are
    r_F = (F - F_m) / s_F          F = sum_i A_iF f_i + b_F,   f_i = c_i S_i + d_i
    r_C = (C - C_m - tau C_m') / s_C    C = (-My, Mx) / F
so dC/df_i = ((-A_iy, A_ix) - C A_iF) / F, and the gain's column is the offset's times S_i.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.moments import WrenchMoments, WrenchResiduals
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.estimation.chunks import chunks
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, weight_below

FloatArray = NDArray[np.float64]
HANGING_STD_N, HANGING_LEVER_M = 0.05, 0.05
"""How far the force that a foot in the air feels is off zero, and the lever of its moments: the
weight of what hangs below the cells is known, and cells hold their zero."""


@dataclass(frozen=True)
class Weights:
    """Standard deviations of one independent sample.

    Attributes:
        force: of the force residual [N].
        cop: of the CoP residual [m].
        correlation: samples within this time count as one [s].
    """

    force: float
    cop: float
    correlation: float

    @classmethod
    def of(cls, settings: CalibrationSettings) -> Weights:
        """As a calibration is told to weigh."""
        return cls(settings.force_std_n, settings.cop_std_m, settings.correlation_s)

    def of_sample(self, stance: Stance) -> float:
        """How much of an independent sample each sample of a stance counts for."""
        if not len(stance.time):
            return 0.0
        return min(1.0, stance.duration / len(stance.time) / self.correlation)


@dataclass(frozen=True)
class Normal:
    """A sum of squares and its Gauss-Newton model at one point.

    Attributes:
        cost: sum of squared residuals.
        gradient: (p,) J^T r.
        hessian: (p, p) J^T J.
    """

    cost: float
    gradient: FloatArray
    hessian: FloatArray

    def __add__(self, other: Normal) -> Normal:
        return Normal(
            self.cost + other.cost,
            self.gradient + other.gradient,
            self.hessian + other.hessian,
        )


def pack(parameters: ChannelParameters, time_offset: float) -> FloatArray:
    """(2n + 1,) parameter vector."""
    return np.concatenate((parameters.gain, parameters.offset, [time_offset]))


def unpack(vector: FloatArray) -> tuple[ChannelParameters, float]:
    """Channel parameters and time offset of a parameter vector."""
    channels = len(vector) // 2
    return (
        ChannelParameters(vector[:channels], vector[channels : 2 * channels]),
        float(vector[-1]),
    )


def errors(vector: FloatArray, stance: Stance, weights: Weights) -> FloatArray:
    """Residuals (3T,): all r_F, then all r_Cx, then all r_Cy."""
    force, place = _measured(vector, stance)
    off = place - stance.cop - vector[-1] * stance.cop_rate
    return np.concatenate(((force - stance.force) / weights.force, *(off / weights.cop).T))


def residuals(
    vector: FloatArray, stance: Stance, weights: Weights
) -> tuple[FloatArray, FloatArray]:
    """`errors` (3T,) and their Jacobian (3T, 2n + 1)."""
    columns = stance.columns
    force, place = _measured(vector, stance)
    slopes = [
        np.broadcast_to(columns[:, 0] / weights.force, stance.readings.shape),
        (-columns[:, 2] - np.outer(place[:, 0], columns[:, 0])) / (force[:, None] * weights.cop),
        (columns[:, 1] - np.outer(place[:, 1], columns[:, 0])) / (force[:, None] * weights.cop),
    ]
    late = [np.zeros_like(force), *(-stance.cop_rate / weights.cop).T]
    jacobian = np.concatenate(
        [
            np.hstack((slope * stance.readings, slope, column[:, None]))
            for slope, column in zip(slopes, late, strict=True)
        ]
    )
    return errors(vector, stance, weights), jacobian


def _measured(vector: FloatArray, stance: Stance) -> tuple[FloatArray, FloatArray]:
    """Force (T,) and CoP (T, 2) by the readings."""
    parameters, _ = unpack(vector)
    force, mx, my = (parameters.outputs(stance.readings) @ stance.columns + stance.base).T
    return force, np.stack((-my, mx), axis=1) / force[:, None]


def hanging_weights(stance: Stance, weights: Weights) -> Weights:
    """Weights of a foot in the air: while the robot stands still, no error of the model matters."""
    if not stance.quasi_static or not len(stance.force):
        return weights
    weight = float(stance.force.mean())
    return Weights(
        min(weights.force, HANGING_STD_N),
        min(weights.cop, HANGING_STD_N * HANGING_LEVER_M / weight),
        weights.correlation,
    )


def hanging_residuals(
    vector: FloatArray, stance: Stance, shoe: Shoe, weights: Weights, weight: float
) -> tuple[FloatArray, FloatArray]:
    """Residuals (3T,) and Jacobian of a foot in the air: its wrench is zero.

    A moment counts by the CoP error that it would cause under a force of `weight` [N].
    """
    foot = stance.hanging
    assert foot is not None
    weights = hanging_weights(stance, weights)
    parameters, _ = unpack(vector)
    columns = np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0)
    wrench = parameters.outputs(stance.readings) @ columns + weight_below(shoe)[foot]
    moment = weights.cop * weight
    scales = np.array([weights.force, moment, moment])
    jacobian = np.concatenate(
        [
            np.hstack(
                (
                    stance.readings * column,
                    np.broadcast_to(column, stance.readings.shape),
                    np.zeros((len(stance.time), 1)),
                )
            )
            / scale
            for column, scale in zip(columns.T, scales, strict=True)
        ]
    )
    return (wrench / scales).T.reshape(-1), jacobian


def normal_equations(
    vector: FloatArray, stances: Sequence[Stance], shoe: Shoe, weights: Weights
) -> Normal:
    """Gauss-Newton model of all residuals of all stances, in bounded memory."""
    return Problem.of(stances, shoe, weights).normal(vector)


def zero_normal(size: int) -> Normal:
    """The Gauss-Newton model of nothing."""
    return Normal(0.0, np.zeros(size), np.zeros((size, size)))


@dataclass(frozen=True)
class Problem:
    """The sum of squares of all residuals of some stances, as a function of the vector.

    The same as from the rows of `residuals` and `hanging_residuals`, but these are never
    written down.

    Attributes:
        terms: loaded feet and hanging ones.
        weights: of the residuals.
    """

    terms: tuple[Term, ...]
    weights: Weights

    @classmethod
    def of(
        cls,
        stances: Sequence[Stance],
        shoe: Shoe,
        weights: Weights,
        shares: Sequence[float] | None = None,
    ) -> Problem:
        """All samples of all stances.

        Args:
            stances, shoe, weights: to be fitted.
            shares: how much each stance that has samples counts for; all of them fully by default.
        """
        terms = []
        full = [stance for stance in stances if len(stance.time)]
        for stance, part in zip(full, shares or [1.0] * len(full), strict=True):
            share = part * weights.of_sample(stance)
            terms.append(Term(stance, share, stance.columns, stance.base, None))
            foot = stance.hanging
            if foot is not None:
                columns = np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0)
                weight = float(stance.force.mean())
                terms.append(Term(stance, share, columns, weight_below(shoe)[foot], weight))
        return cls(tuple(terms), weights)

    @property
    def samples(self) -> int:
        """Number of samples in all terms."""
        return sum(len(term.stance.time) for term in self.terms)

    def thinned(self, step: int) -> Problem:
        """Every `step`-th sample of each stance, each counting for those left out."""
        return replace(self, terms=tuple(term.thinned(step) for term in self.terms))

    def cost(self, vector: FloatArray) -> float:
        """The sum alone: cheaper than `normal`."""
        return sum(
            term.share * float((chunk.rows[0] ** 2).sum())
            for term in self.terms
            for _, chunk in term.chunks(vector, self.weights)
        )

    def normal(self, vector: FloatArray) -> Normal:
        """Its Gauss-Newton model."""
        total = zero_normal(len(vector))
        for term in self.terms:
            sums = WrenchMoments(term.columns)
            for extended, chunk in term.chunks(vector, self.weights):
                sums.add(extended, chunk)
            total += Normal(
                term.share * sums.cost, term.share * sums.gradient(), term.share * sums.hessian()
            )
        return total


@dataclass(frozen=True)
class Term:
    """The loaded feet of one stance, or its hanging foot.

    Attributes:
        stance: the samples.
        share: how much of an independent sample each of them counts for.
        columns: (n, 3) what one unit of each output adds to the wrench.
        base: (3,) wrench of the parts below the channels.
        weight: the force under which a hanging foot's moments count [N]; None for loaded feet.
    """

    stance: Stance
    share: float
    columns: FloatArray
    base: FloatArray
    weight: float | None

    def thinned(self, step: int) -> Term:
        """Every `step`-th sample."""
        stance = self.stance.part(slice(None, None, step))
        return replace(
            self, stance=stance, share=self.share * len(self.stance.time) / len(stance.time)
        )

    def chunks(
        self, vector: FloatArray, weights: Weights
    ) -> Iterator[tuple[FloatArray, WrenchResiduals]]:
        """S~ = (S, 1) as (n + 1, m), and the residuals there."""
        parameters, time_offset = unpack(vector)
        constant = parameters.offset @ self.columns + self.base
        law = np.vstack((parameters.gain[:, None] * self.columns, constant)).T
        for part in chunks(len(self.stance.time)):
            readings = self.stance.readings[part]
            extended = np.ones((law.shape[1], len(readings)))
            extended[:-1] = readings.T
            wrench = law @ extended
            if self.weight is None:
                yield extended, _loaded(wrench, self.stance, part, time_offset, weights)
            else:
                tight = hanging_weights(self.stance, weights)
                yield extended, _hanging(wrench, self.weight, tight)


def _loaded(
    wrench: FloatArray, stance: Stance, part: slice, time_offset: float, weights: Weights
) -> WrenchResiduals:
    """Of wrenches (3, m) that should have the model's force and CoP."""
    force, mx, my = wrench
    inverse = 1.0 / (weights.cop * force)
    place = np.empty((2, len(force)))
    np.multiply(my, -inverse, out=place[0])
    np.multiply(mx, inverse, out=place[1])
    rows = np.zeros((2, *wrench.shape))
    error, late = rows
    np.divide(stance.cop_rate[part].T, -weights.cop, out=late[1:])
    np.multiply(time_offset, late, out=error)
    error[0] = (force - stance.force[part]) / weights.force
    error[1:] += place - stance.cop[part].T / weights.cop
    return WrenchResiduals(rows, 1.0 / weights.force, inverse, place / force)


def _hanging(wrench: FloatArray, weight: float, weights: Weights) -> WrenchResiduals:
    """Of wrenches (3, m) that should be zero; a moment shifts the CoP of `weight` [N]."""
    force, mx, my = wrench
    inverse = np.full_like(force, 1.0 / (weights.cop * weight))
    rows = np.zeros((2, *wrench.shape))
    rows[0] = force / weights.force, -my * inverse, mx * inverse
    return WrenchResiduals(rows, 1.0 / weights.force, inverse, np.zeros((2, len(force))))
