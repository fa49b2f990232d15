"""Effects of cables and connectors."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.files import Fields
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.effects.effect import SensorEffect
from shoecal_core.simulation.effects.location import Channels
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Memoryless, Place, Stage


@dataclass(frozen=True)
class StuckCell(SensorEffect):
    """A reading stays where it was at some time, but for noise and steps of the converter.

    Attributes:
        channels: of any kind.
        share: of the signal that stays (1: the whole; estimates may be a little above).
        time: since the session began, from which on [s]; 0: it never moved from no load.
    """

    channels: Channels
    share: float
    time: float

    @classmethod
    def read(cls, fields: Fields) -> StuckCell:
        """From the item of a reality file."""
        fields.only("effect", "location", "share", "time_s")
        share = fields.number("share", above=0.0, maximum=1.5)
        return cls(Channels.read(fields), share, fields.number("time_s", minimum=0.0))

    def stage(self, shoes: SampledShoes) -> Held:
        """Its law."""
        return Held(self.channels.every(shoes.shoe), self.share, self.time)


@dataclass(frozen=True)
class Held(Stage[FloatArray]):
    """The law of `StuckCell`; remembers the last signals before it."""

    channels: IntArray
    share: float
    time: float
    place = Place.CONTACT

    def start(self) -> FloatArray:
        """(k,) last signals [N or N m]: no load yet."""
        return np.zeros(len(self.channels))

    def __call__(
        self, signal: FloatArray, state: FloatArray, instant: Instant
    ) -> tuple[FloatArray, FloatArray]:
        """The signal (n,) behind it [N or N m]."""
        if instant.time < self.time:
            return signal, signal[self.channels]
        held = signal.copy()
        held[self.channels] += self.share * (state - held[self.channels])
        return held, state


@dataclass(frozen=True)
class SwappedCells(SensorEffect):
    """The cables of two cells are exchanged, and with them their gains, offsets and noise."""

    channels: Channels

    @classmethod
    def read(cls, fields: Fields) -> SwappedCells:
        """From the item of a reality file."""
        fields.only("effect", "location")
        return cls(Channels.read(fields, count=2))

    def stage(self, shoes: SampledShoes) -> Crossed:
        """Its law."""
        chosen = self.channels.every(shoes.shoe)
        if len(set(shoes.shoe.torque[chosen].tolist())) > 1:
            raise self.channels.error("names a force and a torque; name two of one kind")
        return Crossed(chosen)

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes with this stage, and the affine laws that belong to the cells."""
        shoes = super().on_shoes(shoes)
        chosen = self.channels.every(shoes.shoe)
        order = np.arange(len(shoes.channels))
        order[chosen] = chosen[::-1]
        law = shoes.parameters
        return dataclasses.replace(
            shoes,
            parameters=ChannelParameters(law.gain[order], law.offset[order]),
            noise=shoes.noise[order],
        )


@dataclass(frozen=True)
class Crossed(Memoryless):
    """The law of `SwappedCells`."""

    channels: IntArray
    place = Place.SOCKET

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:  # noqa: ARG002
        """The signal (n,) behind it [N or N m]."""
        crossed = signal.copy()
        crossed[self.channels] = signal[self.channels[::-1]]
        return crossed


@dataclass(frozen=True)
class Crosstalk(SensorEffect):
    """A channel shows a part of another one's signal, as that one's own law made it.

    Attributes:
        channels: receiver, donor.
        fraction: of the donor's signal.
    """

    channels: Channels
    fraction: float

    @classmethod
    def read(cls, fields: Fields) -> Crosstalk:
        """From the item of a reality file."""
        fields.only("effect", "location", "fraction")
        fraction = fields.number("fraction", minimum=-1.0, maximum=1.0)
        return cls(Channels.read(fields, count=2), fraction)

    def stage(self, shoes: SampledShoes) -> Leak:
        """Its law."""
        receiver, donor = self.channels.forces(shoes.shoe).tolist()
        return Leak(receiver, donor, self.fraction)


@dataclass(frozen=True)
class Leak(Memoryless):
    """The law of `Crosstalk`."""

    receiver: int
    donor: int
    fraction: float
    place = Place.CABLE

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:  # noqa: ARG002
        """The signal (n,) behind it [N or N m]."""
        mixed = signal.copy()
        mixed[self.receiver] += self.fraction * signal[self.donor]
        return mixed


EFFECTS = {
    "stuck_cell": StuckCell.read,
    "swapped_cells": SwappedCells.read,
    "crosstalk": Crosstalk.read,
}
"""Effects of this family by identifier."""
