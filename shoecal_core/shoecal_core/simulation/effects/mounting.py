"""Effects of how cells are mounted between the plates of a shoe."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.effects.effect import Effect, SensorEffect
from shoecal_core.simulation.effects.location import Channels, read_feet
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant, Memoryless, Place


@dataclass(frozen=True)
class CellPosition(Effect):
    """Cells sit elsewhere than the shoe file says: physically, the plate rests on them there.

    Attributes:
        channels: one-axis cells.
        x, y: true place minus the shoe file's [m], on top of what the reality draws.
    """

    channels: Channels
    x: float
    y: float

    @classmethod
    def read(cls, fields: Fields) -> CellPosition:
        """From the item of a reality file."""
        fields.only("effect", "location", "x_m", "y_m")
        x, y = (fields.number(key, minimum=-0.1, maximum=0.1) for key in ("x_m", "y_m"))
        return cls(Channels.read(fields), x, y)

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes with this effect."""
        position = shoes.position.copy()
        position[self.channels.cells(shoes.shoe)] += self.x, self.y
        return dataclasses.replace(shoes, position=position)


@dataclass(frozen=True)
class OffAxisLoad(SensorEffect):
    """Cells that sideways forces bend: a foot's show x Fx + y Fy more, in equal parts.

    Fx and Fy are the contact forces of the floor on the foot, along its true sole frame. On a
    six-axis sensor the axis of the vertical force shows it.

    Attributes:
        feet: which ones.
        x, y: vertical force felt, over the sideways one.
        channels: the same feet, for messages.
    """

    feet: tuple[str, ...]
    x: float
    y: float
    channels: Channels

    @classmethod
    def read(cls, fields: Fields) -> OffAxisLoad:
        """From the item of a reality file."""
        fields.only("effect", "location", "x", "y")
        x, y = (fields.number(key, minimum=-1.0, maximum=1.0) for key in ("x", "y"))
        return cls(read_feet(fields), x, y, Channels.read(fields, areas=True))

    def stage(self, shoes: SampledShoes) -> SidewaysShare:
        """Its law."""
        gain = np.zeros((len(shoes.channels), len(FEET), 2))
        for name in self.feet:
            foot = FEET.index(name)
            channels = shoes.shoe.of_foot(foot)
            vertical = channels[shoes.shoe.columns[channels, 0] == 1.0]
            if not vertical.size:
                raise self.channels.error(f"no channel of '{name}' reads a vertical force")
            gain[vertical, foot] = np.array([self.x, self.y]) / vertical.size
        return SidewaysShare(gain.reshape(len(gain), -1))


@dataclass(frozen=True)
class SidewaysShare(Memoryless):
    """The law of `OffAxisLoad`; gain: (n, 4) on Fx, Fy of left, then of right."""

    gain: FloatArray
    place = Place.PLATE
    feels_sideways = True

    def passed(self, signal: FloatArray, instant: Instant) -> FloatArray:
        """The signal (n,) behind it [N or N m]."""
        added: FloatArray = signal + self.gain @ instant.sideways.ravel()
        return added


EFFECTS = {"cell_position": CellPosition.read, "off_axis_load": OffAxisLoad.read}
"""Effects of this family by identifier."""
