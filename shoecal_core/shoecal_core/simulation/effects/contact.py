"""Effects between shoe and floor."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import read_feet
from shoecal_core.simulation.sampled_parts import SampledShoes


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
        fields.only("effect", "location", "about_x_rad", "about_y_rad")
        if "location" in fields and fields.texts("location"):
            raise fields.error("location", "names nothing, for the floor has one slope; leave it")
        about_x, about_y = (
            fields.number(name, minimum=-0.3, maximum=0.3)
            for name in ("about_x_rad", "about_y_rad")
        )
        return cls(about_x, about_y)

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The floor with this effect."""
        return dataclasses.replace(shoes, tilt=np.add(shoes.tilt, (self.about_x, self.about_y)))


@dataclass(frozen=True)
class SoftGround(Effect):
    """Floor that gives below some feet: each shoe tilts in it, and sinks as far as it should.

    In the physics it is a bed of springs; where it ends, at the outline, it can only push.

    Attributes:
        feet: which ones.
        compliance: tilt of the shoe, a moment of the floor about the middle of its outline
            [rad/(N m)].
    """

    feet: tuple[str, ...]
    compliance: float

    @classmethod
    def read(cls, fields: Fields) -> SoftGround:
        """From the item of a reality file."""
        fields.only("effect", "location", "compliance_rad_per_nm")
        compliance = fields.number("compliance_rad_per_nm", minimum=0.0, maximum=0.1)
        return cls(read_feet(fields), compliance)

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The floor with this effect."""
        more = np.array([foot in self.feet for foot in FEET]) * self.compliance
        return dataclasses.replace(shoes, ground_compliance=shoes.ground_compliance + more)


EFFECTS: dict[str, Callable[[Fields], Effect]] = {
    "floor_tilt": FloorTilt.read,
    "soft_ground": SoftGround.read,
}
"""Effects of this family by identifier."""
