"""Effects of cells that remember what they carried."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.simulation.effects.effect import SensorEffect
from shoecal_core.simulation.effects.location import Channels
from shoecal_core.simulation.effects.relaxation import relaxed
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Place, Stage

_ELEMENTS = 22
_FINEST, _COARSEST = 1.0 / 3000.0, 0.15
"""Over the full scale: the elements' half widths lie between these."""
_RANGE = 1.0 / 3.0
"""Over the full scale: range of force over which hysteresis leaves the mean slope as it is."""

_TIMES = 0.971167 * np.array([0.25, 0.5, 1.0, 2.0, 4.0])
"""Time constants of creep over the stated one. After that 1 - 1/e of the whole has come."""
_SHARES = np.array([1.0, 2.0, 3.0, 2.0, 1.0]) / 9.0
"""What each adds to the whole."""


@dataclass(frozen=True)
class Hysteresis(SensorEffect):
    """Readings lag behind the direction of the load.

    A Preisach model: f^ = (1 + g) f - sum_k c_k z_k, where each z_k follows f and stops at
    plus or minus r_k (a play element of whole width 2 r_k lags by it). The r_k are spread evenly
    in their logarithm, all c_k are equal. Then a loop over a range R of f is `fraction` R wide in
    its middle whatever R is up to a third of the full scale, as internal friction of metals and
    glue is; with one width it would be so for one range alone. g keeps the slope between a loop's
    tips at 1 for that third.

    Attributes:
        channels: of any kind.
        fraction: whole width of the loop over the range of f; below 0 readings lead.
    """

    channels: Channels
    fraction: float

    @classmethod
    def read(cls, fields: Fields) -> Hysteresis:
        """From the item of a reality file."""
        fields.only("effect", "location", "fraction")
        fraction = fields.number("fraction", minimum=-0.5, maximum=0.5)
        return cls(Channels.read(fields, areas=True), fraction)

    def stage(self, shoes: SampledShoes) -> Loops:
        """Its law."""
        chosen = self.channels.every(shoes.shoe)
        spacing = math.log(_COARSEST / _FINEST) / _ELEMENTS
        widths = _FINEST * np.exp((np.arange(_ELEMENTS) + 0.5) * spacing)
        return Loops(
            chosen,
            shoes.full_scale[chosen, None] * widths,
            # Over a range R they add up to c R (ln 2), c per unit of the logarithm.
            weight=self.fraction / math.log(2.0) * spacing,
            stiffening=float(np.minimum(2.0 * widths / _RANGE, 1.0).sum()),
        )


@dataclass(frozen=True)
class Loops(Stage[tuple[FloatArray, FloatArray]]):
    """The law of `Hysteresis`.

    Attributes:
        stops: (k, elements) r_k [N or N m].
        weight: c_k.
        stiffening: g over c_k.
    """

    channels: IntArray
    stops: FloatArray
    weight: float
    stiffening: float
    place = Place.FRICTION

    def start(self) -> tuple[FloatArray, FloatArray]:
        """Every z_k (k, elements) and the signal (k,) at 0 [N or N m]."""
        return np.zeros_like(self.stops), np.zeros(len(self.channels))

    def __call__(
        self,
        signal: FloatArray,
        state: tuple[FloatArray, FloatArray],
        instant: Instant,  # noqa: ARG002
    ) -> tuple[FloatArray, tuple[FloatArray, FloatArray]]:
        """The signal (n,) behind it [N or N m]."""
        held, before = state
        now = signal[self.channels]
        held = np.minimum(np.maximum(held + (now - before)[:, None], -self.stops), self.stops)
        lagging = signal.copy()
        lagging[self.channels] += self.weight * (self.stiffening * now - held.sum(axis=1))
        return lagging, (held, now)


@dataclass(frozen=True)
class Creep(SensorEffect):
    """Under a steady load readings go on growing, and fall back slowly after it.

    A spectrum of five exponentials over a factor of 16 in time: after a step of 1,
    f^ = 1 + fraction sum_k s_k (1 - exp(-t / tau_k)), which at t = `time` has come as far as one
    exponential of that time constant.

    Attributes:
        channels: of any kind.
        fraction: of a step by which f^ has grown in the end.
        time: [s].
    """

    channels: Channels
    fraction: float
    time: float

    @classmethod
    def read(cls, fields: Fields) -> Creep:
        """From the item of a reality file."""
        fields.only("effect", "location", "fraction", "time_s")
        fraction = fields.number("fraction", minimum=-0.5, maximum=0.5)
        time = fields.number("time_s", above=0.0)
        return cls(Channels.read(fields, areas=True), fraction, time)

    def stage(self, shoes: SampledShoes) -> Spectrum:
        """Its law."""
        return Spectrum(self.channels.every(shoes.shoe), self.fraction, self.time * _TIMES)


@dataclass(frozen=True)
class Spectrum(Stage[tuple[FloatArray, FloatArray]]):
    """The law of `Creep`; times: (exponentials,) [s]."""

    channels: IntArray
    fraction: float
    times: FloatArray
    place = Place.FLOW

    def start(self) -> tuple[FloatArray, FloatArray]:
        """Every exponential (k, exponentials) and the signal (k,) at 0 [N or N m]."""
        count = len(self.channels)
        return np.zeros((count, len(self.times))), np.zeros(count)

    def __call__(
        self, signal: FloatArray, state: tuple[FloatArray, FloatArray], instant: Instant
    ) -> tuple[FloatArray, tuple[FloatArray, FloatArray]]:
        """The signal (n,) behind it [N or N m]."""
        levels, before = state
        now = signal[self.channels]
        levels = relaxed(levels, before[:, None], now[:, None], instant.span, self.times)
        crept = signal.copy()
        crept[self.channels] += self.fraction * levels @ _SHARES
        return crept, (levels, now)


EFFECTS = {"hysteresis": Hysteresis.read, "creep": Creep.read}
"""Effects of this family by identifier."""
