"""Effects of what cells show without a load."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.simulation.effects.effect import SensorEffect
from shoecal_core.simulation.effects.location import Channels
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Memoryless, Place


@dataclass(frozen=True)
class ZeroOffset(SensorEffect):
    """Zeros that are off in one run: f^ = f + offset of each channel, from its beginning on.

    The amplifier adds it: cables, filters and the converter come after it.

    Attributes:
        channels: that read a force.
        offset: [N].
        run: of the session, from 1.
    """

    channels: Channels
    offset: float
    run: int

    @classmethod
    def read(cls, fields: Fields) -> ZeroOffset:
        """From the item of a reality file."""
        fields.only("effect", "location", "offset_n", "run")
        return cls(
            Channels.read(fields, areas=True),
            fields.number("offset_n"),
            fields.integer("run", minimum=1),
        )

    def stage(self, shoes: SampledShoes) -> ZeroStep:
        """Its law."""
        return ZeroStep(self.channels.forces(shoes.shoe), self.offset, self.run)


@dataclass(frozen=True)
class ZeroStep(Memoryless):
    """The law of `ZeroOffset`."""

    channels: IntArray
    offset: float
    run: int
    place = Place.ZERO

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:
        """The signal (n,) behind it [N or N m]."""
        if instant.run != self.run:
            return signal
        stepped = signal.copy()
        stepped[self.channels] += self.offset
        return stepped


EFFECTS = {"zero_offset": ZeroOffset.read}
"""Effects of this family by identifier."""
