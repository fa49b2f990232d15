"""From what the channels feel to what their converter reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.sampled_parts import SampledShoes

GOOD, SATURATED = 0, 1


@dataclass(frozen=True)
class ConvertedReadings:
    """What the converter gave, at one instant or many (...).

    Attributes:
        counts: (..., n) whole steps.
        voltages: (..., n) the same in the shoe's unit.
        status: (..., n) GOOD or SATURATED.
        temperature: (...) of the shoes as the device reports it [degC]; NaN where it does not.
    """

    counts: IntArray
    voltages: FloatArray
    status: NDArray[np.uint8]
    temperature: FloatArray


class AdConverter:
    """Affine law of each channel backwards, noise, steps and ends of the range.

    Attributes:
        volts_per_count: (n,) step of each channel, in the shoe's unit.
    """

    def __init__(
        self, shoe: Shoe, rules: PlantVariation, drawn: SampledShoes, noise: np.random.Generator
    ) -> None:
        lowest, highest = (
            np.array([getattr(channel, end) for channel in shoe.channels])
            for end in ("lowest", "highest")
        )
        self.volts_per_count = (highest - lowest) / 2**rules.cells.converter_bits
        self._lowest = np.ceil(lowest / self.volts_per_count)
        self._highest = np.floor(highest / self.volts_per_count)
        self._parameters = drawn.parameters
        self._std = drawn.noise
        self._temperature = drawn.temperature
        self._noise = noise

    def __call__(self, outputs: FloatArray, time: ArrayLike = 0.0) -> ConvertedReadings:
        """Read outputs (..., n) [N or N m] at times (...) since the session began [s]."""
        felt = outputs + self._std * self._noise.standard_normal(outputs.shape)
        voltages = (felt - self._parameters.offset) / self._parameters.gain
        counts = np.rint(voltages / self.volts_per_count)
        clipped = np.clip(counts, self._lowest, self._highest)
        return ConvertedReadings(
            counts=clipped.astype(np.int64),
            voltages=clipped * self.volts_per_count,
            status=np.where(clipped == counts, GOOD, SATURATED).astype(np.uint8),
            temperature=self._temperature.reading(np.broadcast_to(time, outputs.shape[:-1])),
        )
