"""Effects between shoe and floor."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.files import Fields
from shoecal_core.simulation.drawn import DrawnShoes
from shoecal_core.simulation.effects.effect import Effect


@dataclass(frozen=True)
class FloorTilt(Effect):
    """The floor is not level.

    Attributes:
        about_x, about_y: turn of the floor [rad].
    """

    about_x: float
    about_y: float

    @classmethod
    def read(cls, fields: Fields) -> FloorTilt:
        """From the item of a reality file."""
        fields.only("effect", "about_x_rad", "about_y_rad")
        about_x, about_y = (
            fields.number(name, minimum=-0.3, maximum=0.3)
            for name in ("about_x_rad", "about_y_rad")
        )
        return cls(about_x, about_y)

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        """The floor with this effect."""
        return dataclasses.replace(shoes, tilt=np.add(shoes.tilt, (self.about_x, self.about_y)))


EFFECTS = {"floor_tilt": FloorTilt.read}
"""Effects of this family by identifier."""
