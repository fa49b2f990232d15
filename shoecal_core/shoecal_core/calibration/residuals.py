"""Residuals of measured GRF and CoP against the model, and their derivatives (paper, eq. 18).

The parameter vector, in this order everywhere: n gains, n offsets, the time offset.
A sample's residuals are
    r_F = (F - F_m) / s_F          F = sum_i A_iF f_i + b_F,   f_i = c_i S_i + d_i
    r_C = (C - C_m - tau C_m') / s_C    C = (-My, Mx) / F
so dC/df_i = ((-A_iy, A_ix) - C A_iF) / F, and the gain's column is the offset's times S_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.stance import Stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, weight_below

FloatArray = NDArray[np.float64]
CHUNK = 4096
"""Samples whose Jacobian is held at once: bounds the memory whatever the recording."""


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


def residuals(
    vector: FloatArray, stance: Stance, weights: Weights
) -> tuple[FloatArray, FloatArray]:
    """Residuals (3T,) and Jacobian (3T, 2n + 1): all r_F, then all r_Cx, then all r_Cy."""
    parameters, time_offset = unpack(vector)
    columns = stance.columns
    wrench = parameters.outputs(stance.readings) @ columns + stance.base
    force = wrench[:, 0]
    place = np.stack((-wrench[:, 2], wrench[:, 1]), axis=1) / force[:, None]
    off = place - stance.cop - time_offset * stance.cop_rate
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
    error = np.concatenate(
        ((force - stance.force) / weights.force, off[:, 0] / weights.cop, off[:, 1] / weights.cop)
    )
    return error, jacobian


def hanging_residuals(
    vector: FloatArray, stance: Stance, shoe: Shoe, weights: Weights, weight: float
) -> tuple[FloatArray, FloatArray]:
    """Residuals (3T,) and Jacobian of a foot in the air: its wrench is zero.

    A moment counts by the CoP error that it would cause under a force of `weight` [N].
    """
    foot = stance.hanging
    assert foot is not None
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
    total = zero_normal(len(vector))
    for stance in stances:
        share = weights.of_sample(stance)
        weight = float(np.mean(stance.force)) if len(stance.force) else 0.0
        for piece in _chunks(stance):
            total += _normal(*residuals(vector, piece, weights), share)
            if piece.hanging is not None:
                total += _normal(*hanging_residuals(vector, piece, shoe, weights, weight), share)
    return total


def zero_normal(size: int) -> Normal:
    """The Gauss-Newton model of nothing."""
    return Normal(0.0, np.zeros(size), np.zeros((size, size)))


def _normal(error: FloatArray, jacobian: FloatArray, share: float) -> Normal:
    return Normal(
        share * float(error @ error), share * (jacobian.T @ error), share * (jacobian.T @ jacobian)
    )


def _chunks(stance: Stance) -> list[Stance]:
    count = len(stance.time)
    if count <= CHUNK:
        return [stance]
    return [stance.part(slice(start, start + CHUNK)) for start in range(0, count, CHUNK)]
