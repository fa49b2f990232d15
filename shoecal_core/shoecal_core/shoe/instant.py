"""Calibrated sensing of one instant in plain numbers: what `Sensing.measure` gives, much sooner.

For eight cells an array costs far more than the arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.shoe.correction import POLYNOMIAL, CopCorrection, corrected_channels
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import weight_below

Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class FootInstant:
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


class InstantSensing:
    """Both feet under one set of parameters."""

    def __init__(self, sensing: Sensing) -> None:
        """Takes everything over from `sensing`."""
        corrections = {correction.foot: correction for correction in sensing.corrections}
        self._feet = tuple(_Foot(sensing, foot, corrections.get(foot)) for foot in (0, 1))

    def measure(self, readings: Sequence[float]) -> tuple[FootInstant, FootInstant]:
        """GRF and CoP of the left and of the right foot.

        Args:
            readings: n raw ones, in the shoe's channel order; NaN makes its foot NaN.
        """
        left, right = self._feet
        return left.measure(readings), right.measure(readings)


class _Foot:
    def __init__(self, sensing: Sensing, foot: int, correction: CopCorrection | None) -> None:
        shoe, law = sensing.shoe, sensing.parameters
        own = shoe.of_foot(foot)
        # Index, gain, offset, and column (vertical force, moments about x and y) of each channel.
        self._channels = [
            (int(index), float(law.gain[index]), float(law.offset[index]), *column)
            for index, column in zip(own, shoe.columns[own].tolist(), strict=True)
        ]
        self._below: tuple[float, ...] = tuple(weight_below(shoe)[foot].tolist())
        self._minimum_force = sensing.minimum_force if shoe.gives_cop[foot] else math.inf
        self._correction: _Correction | None = None
        if correction is not None:
            felt = set(corrected_channels(shoe, foot).tolist())
            places = [place for place, index in enumerate(own.tolist()) if index in felt]
            self._correction = _Correction(correction, places)

    def measure(self, readings: Sequence[float]) -> FootInstant:
        force, about_x, about_y = self._below
        outputs = []
        for index, gain, offset, up, x, y in self._channels:
            output = gain * readings[index] + offset
            outputs.append(output)
            force += up * output
            about_x += x * output
            about_y += y * output
        if not force > self._minimum_force or not math.isfinite(about_x + about_y):
            return FootInstant(force, None, extrapolating=False)
        raw = (-about_y / force, about_x / force)
        if self._correction is None:
            return FootInstant(force, raw, extrapolating=False)
        return self._correction.corrected(force, raw, outputs)


class _Correction:
    """Equations 4 and 5 of the paper for one foot."""

    def __init__(self, correction: CopCorrection, places: list[int]) -> None:
        self._places = places
        self._polynomials = [line[:POLYNOMIAL].tolist() for line in (correction.x, correction.y)]
        self._shares = [line[POLYNOMIAL:].tolist() for line in (correction.x, correction.y)]
        self._cop_range = correction.cop_range.T.tolist()
        self._output_range = correction.output_range.T.tolist()

    def corrected(self, force: float, raw: Place, outputs: Sequence[float]) -> FootInstant:
        felt = [outputs[place] for place in self._places]
        x, y = raw
        place = (x + self._shift(0, x, y, felt), y + self._shift(1, y, x, felt))
        inside = all(
            low <= value <= high
            for value, (low, high) in zip(
                (*raw, *felt), (*self._cop_range, *self._output_range), strict=True
            )
        )
        return FootInstant(force, place, extrapolating=not inside)

    def _shift(self, axis: int, along: float, across: float, felt: Sequence[float]) -> float:
        square, line, side, constant = self._polynomials[axis]
        shift: float = square * along * along + line * along + side * across + constant
        return shift + sum(map(float.__mul__, self._shares[axis], felt))
