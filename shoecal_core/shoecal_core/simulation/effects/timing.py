"""Effects of time between a force and its reading."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.effects.effect import Effect, SensorEffect
from shoecal_core.simulation.effects.location import read_feet
from shoecal_core.simulation.effects.relaxation import relaxed
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Place, Stage


@dataclass(frozen=True)
class Latency(Effect):
    """Readings of some feet are old.

    Attributes:
        feet: which ones.
        delay: [s].
    """

    feet: tuple[str, ...]
    delay: float

    @classmethod
    def read(cls, fields: Fields) -> Latency:
        """From the item of a reality file."""
        fields.only("effect", "location", "delay_s")
        return cls(read_feet(fields), fields.number("delay_s", minimum=0.0, maximum=1.0))

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes with this effect."""
        late = np.array([name.split("/")[0] in self.feet for name in shoes.channels])
        return dataclasses.replace(shoes, latency=shoes.latency + late * self.delay)


@dataclass(frozen=True)
class LowPass(SensorEffect):
    """Readings of some feet lag behind.

    Two equal lags one after the other, each of half the time: a ramp comes late by the whole
    time as behind one lag, a step begins softly.

    Attributes:
        feet: which ones.
        time: [s].
    """

    feet: tuple[str, ...]
    time: float

    @classmethod
    def read(cls, fields: Fields) -> LowPass:
        """From the item of a reality file."""
        fields.only("effect", "location", "time_s")
        return cls(read_feet(fields), fields.number("time_s", above=0.0, maximum=10.0))

    def stage(self, shoes: SampledShoes) -> Lags:
        """Its law."""
        foot = [FEET.index(name) for name in self.feet]
        return Lags(np.flatnonzero(np.isin(shoes.shoe.foot, foot)), self.time / 2.0)


@dataclass(frozen=True)
class Lags(Stage[tuple[FloatArray, FloatArray, FloatArray]]):
    """The law of `LowPass`; remembers the input, the first lag and the second."""

    channels: IntArray
    time: float
    place = Place.FILTER

    def start(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Input, first and second lag (k,), all 0 [N or N m]."""
        nothing = np.zeros(len(self.channels))
        return nothing, nothing, nothing

    def __call__(
        self,
        signal: FloatArray,
        state: tuple[FloatArray, FloatArray, FloatArray],
        instant: Instant,
    ) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
        """The signal (n,) behind it [N or N m]."""
        before, first_before, second = state
        now = signal[self.channels]
        first = relaxed(first_before, before, now, instant.span, self.time)
        second = relaxed(second, first_before, first, instant.span, self.time)
        late = signal.copy()
        late[self.channels] = second
        return late, (now, first, second)


EFFECTS = {"latency": Latency.read, "low_pass": LowPass.read}
"""Effects of this family by identifier."""
