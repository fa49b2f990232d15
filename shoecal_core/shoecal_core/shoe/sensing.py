"""Calibrated sensing: readings in, GRF and CoP out, for batches.

`InstantSensing` gives the same for one instant, much sooner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.correction import CopCorrection, check_corrections, corrected_channels
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    at_cop,
    combined,
    cop,
    foot_wrenches,
)

FloatArray = NDArray[np.float64]
MINIMUM_FORCE = 2.0
"""N; a foot that carries less has no CoP."""


@dataclass(frozen=True)
class Measured:
    """Both feet at T instants (any leading shape).

    Attributes:
        grf: (..., 2) vertical force of each foot [N].
        cop: (..., 2, 2) CoP of each foot in its sole frame [m]; NaN where it is unloaded, or its
            channels give a force alone.
        extrapolating: (..., 2) outside what the correction was trained on.
    """

    grf: FloatArray
    cop: FloatArray
    extrapolating: NDArray[np.bool_]

    @property
    def total_grf(self) -> FloatArray:
        """(...,) vertical force of both feet [N]."""
        total: FloatArray = self.grf.sum(axis=-1)
        return total

    def combined_cop(self, support: DoubleSupport) -> FloatArray:
        """(..., 2) CoP of both feet in the left sole's frame [m].

        An unloaded foot adds nothing; NaN where no foot is loaded, and where a foot's force is
        not known.
        """
        loaded = np.isfinite(self.cop[..., 0])
        known = np.isfinite(self.grf)
        wrenches = at_cop(
            np.where(loaded | ~known, self.grf, 0.0), np.where(loaded[..., None], self.cop, 0.0)
        )
        return cop(combined(wrenches, support), minimum_force=0.0)


class Sensing:
    """The measuring side of one pair of shoes under one set of parameters.

    Raises:
        ShapeError: parameters or corrections are not of this shoe's channels.
        ShoecalError: a foot has two corrections.
    """

    def __init__(
        self,
        shoe: Shoe,
        parameters: ChannelParameters,
        corrections: Sequence[CopCorrection] = (),
        minimum_force: float = MINIMUM_FORCE,
    ) -> None:
        count = len(shoe.channels)
        if parameters.gain.shape != (count,):
            raise ShapeError("gain", f"({count},)", parameters.gain.shape)
        check_corrections(shoe, corrections)
        self.shoe = shoe
        self.parameters = parameters
        self.corrections = tuple(corrections)
        self.minimum_force = minimum_force

    def measure(self, readings: FloatArray) -> Measured:
        """GRF and CoP of each foot.

        Args:
            readings: (..., n) raw, in the shoe's channel order; NaN makes its foot NaN.
        """
        outputs = self.parameters.outputs(readings)
        wrenches = foot_wrenches(self.shoe, outputs)
        place = cop(wrenches, self.minimum_force)
        for foot in (0, 1):
            if not self.shoe.gives_cop[foot]:
                place[..., foot, :] = np.nan
        extrapolating = np.zeros(place.shape[:-1], dtype=bool)
        for correction in self.corrections:
            foot = correction.foot
            own = outputs[..., corrected_channels(self.shoe, foot)]
            extrapolating[..., foot] = correction.extrapolates(place[..., foot, :], own)
            place[..., foot, :] = correction.correct(place[..., foot, :], own)
        return Measured(wrenches[..., 0], place, extrapolating)
