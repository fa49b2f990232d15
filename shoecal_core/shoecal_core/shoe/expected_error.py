"""How far GRF and CoP may be off when gains and offsets are uncertain.

To first order. An output f_i = c_i S_i + d_i moves by S_i with its gain and by one with its
offset; force F and CoP C = (-My, Mx) / F of columns A_i move with it by

    dF/df_i = A_iF        dC/df_i = ((-A_iy, A_ix) - C A_iF) / F

so the covariance of F and C is J P J^T, with P that of [gains, offsets].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    by_parameters,
    columns_in_left,
    combined,
    cop_jacobian,
    foot_wrenches,
)


@dataclass(frozen=True)
class ExpectedError:
    """Standard deviations of GRF and CoP at p load cases; CoP corrections are not in them.

    Attributes:
        grf: (p,) of both feet together [N].
        cop: (p,) length of the CoP's error of both feet together, root mean square; NaN where
            nothing is loaded or no double support is given [m].
        foot_grf: (p, 2) of left and right [N].
        foot_cop: (p, 2) likewise; NaN where the foot is unloaded [m].
    """

    grf: FloatArray
    cop: FloatArray
    foot_grf: FloatArray
    foot_cop: FloatArray

    def __post_init__(self) -> None:
        count = len(self.grf)
        shapes = {"grf": (count,), "cop": (count,), "foot_grf": (count, 2), "foot_cop": (count, 2)}
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ShapeError(f"expected {name}", str(shape), getattr(self, name).shape)


def expected_error(
    shoe: Shoe,
    support: DoubleSupport | None,
    outputs: FloatArray,
    readings: FloatArray,
    covariance: FloatArray,
) -> ExpectedError:
    """Propagate the covariance of gains and offsets to GRF and CoP.

    Args:
        shoe: with n channels.
        support: where the right foot is; None where no CoP of both feet is wanted.
        outputs: (p, n) of all channels in each load case [N or N m].
        readings: (p, n) what the gains multiply: raw readings for a covariance of gains, outputs
            less offsets for one of relative gains.
        covariance: (2n, 2n) of [gains, offsets].

    Raises:
        ShapeError: arrays that do not belong together.
        ShoecalError: a covariance that is not finite.
    """
    count = len(shoe.channels)
    if outputs.ndim != 2 or outputs.shape[1] != count:
        raise ShapeError("outputs", f"(p, {count})", outputs.shape)
    if readings.shape != outputs.shape:
        raise ShapeError("readings", str(outputs.shape), readings.shape)
    if covariance.shape != (2 * count, 2 * count):
        raise ShapeError("covariance", f"({2 * count}, {2 * count})", covariance.shape)
    if not np.isfinite(covariance).all():
        raise ShoecalError("the covariance holds a number that is not finite")
    wrenches = foot_wrenches(shoe, outputs)
    feet = [
        _deviations(
            np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0),
            wrenches[:, foot],
            readings,
            covariance,
        )
        for foot in (0, 1)
    ]
    # Without a double support the sum of forces still stands; any place of the feet will do.
    placed = DoubleSupport(0.0, 0.0, 0.0) if support is None else support
    grf, cop = _deviations(
        columns_in_left(shoe, placed), combined(wrenches, placed), readings, covariance
    )
    return ExpectedError(
        grf=grf,
        cop=np.full_like(cop, np.nan) if support is None else cop,
        foot_grf=np.stack([force for force, _ in feet], axis=1),
        foot_cop=np.stack([place for _, place in feet], axis=1),
    )


def _deviations(
    columns: FloatArray, wrench: FloatArray, readings: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Standard deviations (p,) of force [N] and CoP [m] of the channels with these columns."""
    loaded = wrench[:, 0] > MINIMUM_FORCE
    # Where there is no CoP, the slopes of a CoP under a unit force stand in, and are left out.
    slopes = cop_jacobian(np.where(loaded[:, None], wrench, [1.0, 0.0, 0.0])) @ columns.T
    jacobian = by_parameters(slopes, readings)
    variances = np.clip(((jacobian @ covariance) * jacobian).sum(axis=2), 0.0, None)
    place = np.sqrt(variances[:, 1:].sum(axis=1))
    return np.sqrt(variances[:, 0]), np.where(loaded, place, np.nan)
