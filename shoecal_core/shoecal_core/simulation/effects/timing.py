"""Effects of time between a force and its reading."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.files import Fields
from shoecal_core.simulation.drawn import DrawnShoes
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import read_feet


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

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        """The shoes with this effect."""
        late = np.array([name.split("/")[0] in self.feet for name in shoes.channels])
        return dataclasses.replace(shoes, latency=shoes.latency + late * self.delay)


EFFECTS = {"latency": Latency.read}
"""Effects of this family by identifier."""
