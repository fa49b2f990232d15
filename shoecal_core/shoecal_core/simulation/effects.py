"""Effects that a reality file lists: each changes the numbers drawn for one robot.

Their identifiers, locations and sizes are those that a diagnosis reports.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.files import Fields
from shoecal_core.sensing.shoe import FEET
from shoecal_core.simulation.drawn import DrawnBody, DrawnShoes
from shoecal_core.simulation.reality import ALL


class Effect:
    """One effect of the real world; without more it changes nothing."""

    def on_body(self, body: DrawnBody) -> DrawnBody:
        """The robot with this effect."""
        return body

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        """The shoes, and the floor below them, with this effect."""
        return shoes


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
        feet = FEET if fields.texts("location") == [ALL] else tuple(fields.texts("location"))
        for foot in feet:
            if foot not in FEET:
                raise fields.error("location", f"'{foot}' is not one of: {', '.join(FEET)}, {ALL}")
        return cls(feet, fields.number("delay_s", minimum=0.0, maximum=1.0))

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        """The shoes with this effect."""
        late = np.array([name.split("/")[0] in self.feet for name in shoes.channels])
        return dataclasses.replace(shoes, latency=shoes.latency + late * self.delay)


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


EFFECTS: Mapping[str, Callable[[Fields], Effect]] = {
    "latency": Latency.read,
    "floor_tilt": FloorTilt.read,
}
"""Effects by identifier."""


def read_effect(fields: Fields) -> Effect:
    """One item of a reality file's list of effects.

    Raises:
        FileError: for an unknown effect or a size that is missing or mistyped.
    """
    return EFFECTS[fields.choice("effect", EFFECTS)](fields)
