"""Residuals of measured GRF and CoP against the model, and their derivatives (paper, eq. 18).

The parameter vector, in this order everywhere: n gains, n offsets, the time offset.
A sample's residuals are
    r_F = (F - F_m) / s_F          F = sum_i A_iF f_i + b_F,   f_i = c_i S_i + d_i
    r_C = (C - C_m - tau C_m') / s_C    C = (-My, Mx) / F
so dC/df_i = ((-A_iy, A_ix) - C A_iF) / F, and the gain's column is the offset's times S_i.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, by_parameters, cop_jacobian, weight_below

HANGING_STD_N, HANGING_LEVER_M = 0.05, 0.05
"""How far the force that a foot in the air feels is off zero, and the lever of its moments: the
weight of what hangs below the cells is known, and cells hold their zero."""


@dataclass(frozen=True)
class ResidualWeights:
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
    def of(cls, settings: CalibrationSettings) -> ResidualWeights:
        """By a calibration's settings."""
        return cls(settings.force_std_n, settings.cop_std_m, settings.correlation_s)

    def of_sample(self, stance: Stance) -> float:
        """How much of an independent sample each sample of a stance counts for."""
        if not len(stance.time):
            return 0.0
        return min(1.0, stance.duration / len(stance.time) / self.correlation)


def pack(parameters: ChannelParameters, time_offset: float) -> FloatArray:
    """(2n + 1,) parameter vector: gains, offsets [N or N m], time offset [s]."""
    return np.concatenate((parameters.gain, parameters.offset, [time_offset]))


def unpack(vector: FloatArray) -> tuple[ChannelParameters, float]:
    """Channel parameters and time offset [s] of a parameter vector (2n + 1,)."""
    channels = len(vector) // 2
    return (
        ChannelParameters(vector[:channels], vector[channels : 2 * channels]),
        float(vector[-1]),
    )


def errors(vector: FloatArray, stance: Stance, weights: ResidualWeights) -> FloatArray:
    """Residuals (3T,) in standard deviations: all r_F, then all r_Cx, then all r_Cy."""
    force, mx, my = _wrench(vector, stance).T
    off = np.stack((-my, mx), axis=1) / force[:, None] - stance.cop - vector[-1] * stance.cop_rate
    return np.concatenate(((force - stance.force) / weights.force, *(off / weights.cop).T))


def residuals(
    vector: FloatArray, stance: Stance, weights: ResidualWeights
) -> tuple[FloatArray, FloatArray]:
    """`errors` (3T,) and their Jacobian (3T, 2n + 1)."""
    late = np.pad(-stance.cop_rate, ((0, 0), (1, 0)))
    own = by_parameters(cop_jacobian(_wrench(vector, stance)) @ stance.columns.T, stance.readings)
    scales = np.array([weights.force, weights.cop, weights.cop])
    jacobian = np.concatenate((own, late[:, :, None]), axis=2) / scales[:, None]
    return errors(vector, stance, weights), _by_row(jacobian)


def _wrench(vector: FloatArray, stance: Stance) -> FloatArray:
    """(T, 3) by the readings."""
    wrench: FloatArray = unpack(vector)[0].outputs(stance.readings) @ stance.columns + stance.base
    return wrench


def _by_row(jacobian: FloatArray) -> FloatArray:
    """(3T, p) of (T, 3, p): all of the force, then all of the CoP's x, then of its y."""
    return jacobian.swapaxes(0, 1).reshape(-1, jacobian.shape[-1])


def hanging_weights(stance: Stance, weights: ResidualWeights) -> ResidualWeights:
    """Weights of a foot in the air: while the robot stands still, no error of the model matters."""
    if not stance.quasi_static or not len(stance.force):
        return weights
    weight = float(stance.force.mean())
    return ResidualWeights(
        min(weights.force, HANGING_STD_N),
        min(weights.cop, HANGING_STD_N * HANGING_LEVER_M / weight),
        weights.correlation,
    )


def hanging_residuals(
    vector: FloatArray, stance: Stance, shoe: Shoe, weights: ResidualWeights, weight: float
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
    own = by_parameters(columns.T / scales[:, None], stance.readings)
    jacobian = np.pad(own, ((0, 0), (0, 0), (0, 1)))
    return (wrench / scales).T.reshape(-1), _by_row(jacobian)


def rows_of(
    stances: Sequence[Stance],
    shoe: Shoe,
    weights: ResidualWeights,
    shares: Sequence[float] | None = None,
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    """Residuals (r,) of some stances and their Jacobian (r, 2n + 1) as a function of the vector.

    Args:
        stances, shoe, weights: to be fitted.
        shares: how much each stance counts for; all of them fully by default.
    """
    size = 2 * len(shoe.names) + 1

    def rows(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        errors, jacobians = [np.zeros(0)], [np.zeros((0, size))]
        for stance, share in zip(stances, shares or [1.0] * len(stances), strict=True):
            if not len(stance.time):
                continue
            parts = [residuals(vector, stance, weights)]
            if stance.hanging is not None:
                weight = float(stance.force.mean())
                parts.append(hanging_residuals(vector, stance, shoe, weights, weight))
            root = np.sqrt(share * weights.of_sample(stance))
            errors += [root * error for error, _ in parts]
            jacobians += [root * jacobian for _, jacobian in parts]
        return np.concatenate(errors), np.concatenate(jacobians)

    return rows


def thinned(stances: Sequence[Stance], most: int) -> list[Stance]:
    """Every k-th sample of each stance, so that there are not many more than `most` in all.

    Those that are left count for the others: samples count by the time they stand for.
    """
    step = math.ceil(sum(len(stance.time) for stance in stances) / most)
    return [stance.part(slice(None, None, step)) for stance in stances] if step > 1 else [*stances]
