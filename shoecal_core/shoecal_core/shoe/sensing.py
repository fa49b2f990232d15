"""Calibrated sensing: readings in, GRF and CoP out, of one instant or of many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.correction import CopCorrection, N, check_corrections, corrected_channels
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, combined, cop, weight_below

Place = tuple[float, float]
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
    extrapolating: BoolArray

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


class FootInstant(NamedTuple):
    """One foot at one instant.

    Attributes:
        force: vertical [N], NaN where a reading is.
        cop: in its sole's frame [m]; None where it carries too little or is not known, and where
            the channels give a force alone.
        extrapolating: outside what the CoP correction was trained on.
    """

    force: float
    cop: Place | None
    extrapolating: bool


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

        own = {correction.foot: correction for correction in corrections}
        self._feet = tuple(_Foot(self, foot, own.get(foot)) for foot in (0, 1))

    def measure(self, readings: FloatArray) -> Measured:
        """GRF and CoP of each foot at many instants.

        Args:
            readings: (..., n) raw, in the shoe's channel order; NaN makes its foot NaN.
        """
        if readings.shape[-1] != len(self.shoe.channels):
            raise ShapeError("readings", f"(..., {len(self.shoe.channels)})", readings.shape)
        shape = (*readings.shape[:-1], 2)
        grf, place = np.empty(shape), np.empty((*shape, 2))
        extrapolating = np.zeros(shape, dtype=bool)
        channels = [readings[..., index] for index in range(readings.shape[-1])]
        for index, foot in enumerate(self._feet):
            (force, about_x, about_y), outputs = foot.wrench(channels)
            divisor = np.where(force > foot.minimum_force, force, np.nan)
            raw = (-about_y / divisor, about_x / divisor)
            grf[..., index] = force
            if foot.correction is not None:
                felt = foot.felt(outputs)
                extrapolating[..., index] = foot.correction.extrapolates(raw, felt)
                raw = foot.correction.correct(raw, felt)
            place[..., index, 0], place[..., index, 1] = raw
        return Measured(grf, place, extrapolating)

    def measure_instant(self, readings: Sequence[float]) -> tuple[FootInstant, FootInstant]:
        """GRF and CoP of the left and of the right foot at one instant.

        The same as `measure`, without arrays: for eight cells they cost far more than the
        arithmetic.

        Args:
            readings: n raw ones, in the shoe's channel order; NaN makes its foot NaN.
        """
        left, right = self._feet
        return left.at_instant(readings), right.at_instant(readings)


class _Foot:
    """The equations of one foot, for plain numbers (one instant) and for arrays (many)."""

    def __init__(self, sensing: Sensing, foot: int, correction: CopCorrection | None) -> None:
        shoe, law = sensing.shoe, sensing.parameters
        own = shoe.of_foot(foot)
        # Index, gain, offset, and column (vertical force, moments about x and y) of each channel.
        self._channels = [
            (int(index), float(law.gain[index]), float(law.offset[index]), *column)
            for index, column in zip(own, shoe.columns[own].tolist(), strict=True)
        ]
        self._below = weight_below(shoe)[foot].tolist()
        felt = set(corrected_channels(shoe, foot).tolist())
        self._felt = [place for place, index in enumerate(own.tolist()) if index in felt]
        self.minimum_force = sensing.minimum_force if shoe.gives_cop[foot] else math.inf
        self.correction = correction

    def wrench(self, readings: Sequence[N]) -> tuple[tuple[N, N, N], list[N]]:
        """F [N], Mx, My [N m] in the sole frame, and the outputs of the foot's channels."""
        force, about_x, about_y = self._below
        outputs = []
        for index, gain, offset, up, x, y in self._channels:
            output = gain * readings[index] + offset
            outputs.append(output)
            force += up * output
            about_x += x * output
            about_y += y * output
        return (force, about_x, about_y), outputs

    def felt(self, outputs: Sequence[N]) -> list[N]:
        """Those of the outputs that the correction has a term for."""
        return [outputs[place] for place in self._felt]

    def at_instant(self, readings: Sequence[float]) -> FootInstant:
        """Force, CoP and whether it extrapolates."""
        (force, about_x, about_y), outputs = self.wrench(readings)
        if not force > self.minimum_force or not math.isfinite(about_x + about_y):
            return FootInstant(force, None, extrapolating=False)
        raw = (-about_y / force, about_x / force)
        if self.correction is None:
            return FootInstant(force, raw, extrapolating=False)
        felt = self.felt(outputs)
        outside = self.correction.extrapolates(raw, felt)
        return FootInstant(force, self.correction.correct(raw, felt), extrapolating=bool(outside))
