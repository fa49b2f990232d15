"""Effects of the robot's body: masses and their inertia, encoders, gears, the ankle's end."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.errors import FieldError
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import Parts, read_feet, read_shift
from shoecal_core.simulation.reality import ALL
from shoecal_core.simulation.sampled_parts import SampledBody


@dataclass(frozen=True)
class TotalMass(Effect):
    """Another mass of the whole robot: every link's mass and inertia in the same proportion.

    Attributes:
        mass: true minus the model's [kg].
        path, field: where it was written, for messages.
    """

    mass: float
    path: Path
    field: str

    @classmethod
    def read(cls, fields: Fields) -> TotalMass:
        """From the item of a reality file."""
        fields.only("effect", "location", "mass_kg")
        if fields.texts("location") != [ALL]:
            raise fields.error("location", f"must be [{ALL}]; a payload sits on one link")
        mass = fields.number("mass_kg", minimum=-10.0, maximum=10.0)
        return cls(mass, fields.path, f"{fields.prefix}.mass_kg")

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect.

        Raises:
            FieldError: when it leaves nothing of the robot.
        """
        mass = body.mass + self.mass
        if mass <= 0.0:
            raise FieldError(
                self.path, f"must be above {-body.mass:.3g}, the robot's own", field=self.field
            )
        return dataclasses.replace(body, mass=mass)


@dataclass(frozen=True)
class Payload(Effect):
    """A small ball, welded to links where the model has their CoM; the robot gets that heavier.

    Attributes:
        links: that carry one each.
        mass: of one [kg].
    """

    links: Parts
    mass: float

    @classmethod
    def read(cls, fields: Fields) -> Payload:
        """From the item of a reality file."""
        fields.only("effect", "location", "mass_kg")
        return cls(Parts.read(fields, "link"), fields.number("mass_kg", minimum=0.0, maximum=10.0))

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        carried = self.links.mask(body.robot) * self.mass
        return dataclasses.replace(body, payload=body.payload + carried)


@dataclass(frozen=True)
class LinkCom(Effect):
    """Links whose CoM lies elsewhere: in the physics the mass itself does.

    Attributes:
        links: which ones.
        shift: (x, y, z) true CoM minus the model's, in the link's frame [m].
    """

    links: Parts
    shift: tuple[float, float, float]

    @classmethod
    def read(cls, fields: Fields) -> LinkCom:
        """From the item of a reality file."""
        fields.only("effect", "location", "x_m", "y_m", "z_m")
        x, y, z = (
            fields.number(key, 0.0, minimum=-0.5, maximum=0.5) for key in ("x_m", "y_m", "z_m")
        )
        return cls(Parts.read(fields, "link"), (x, y, z))

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        shifted = np.outer(self.links.mask(body.robot), self.shift)
        return dataclasses.replace(body, com_error=body.com_error + shifted)


@dataclass(frozen=True)
class JointOffset(Effect):
    """Encoders whose zero is wrong; joints of one motor share its encoder.

    The servo follows its encoder, so it is the link that stands wrong.

    Attributes:
        joints: which ones.
        angle: encoder reading minus true angle [rad].
    """

    joints: Parts
    angle: float

    @classmethod
    def read(cls, fields: Fields) -> JointOffset:
        """From the item of a reality file."""
        fields.only("effect", "location", "angle_rad")
        return cls(
            Parts.read(fields, "joint"), fields.number("angle_rad", minimum=-0.5, maximum=0.5)
        )

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        error = self.joints.mask(body.robot) * self.angle
        for motor in body.robot.shared:
            if error[motor.leader] == 0.0:
                error[motor.leader] = error[motor.joint] / motor.ratio
            error[motor.joint] = motor.ratio * error[motor.leader]
        return dataclasses.replace(body, encoder_error=body.encoder_error + error)


@dataclass(frozen=True)
class JointCompliance(Effect):
    """Gears and brackets that give, behind the encoder: springs of the physics, in series.

    Attributes:
        joints: which ones.
        compliance: on top of what the reality has [rad/(N m)].
    """

    joints: Parts
    compliance: float

    @classmethod
    def read(cls, fields: Fields) -> JointCompliance:
        """From the item of a reality file."""
        fields.only("effect", "location", "compliance_rad_per_nm")
        compliance = fields.number("compliance_rad_per_nm", minimum=0.0, maximum=1.0)
        return cls(Parts.read(fields, "joint"), compliance)

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        more = self.joints.mask(body.robot) * self.compliance
        return dataclasses.replace(body, compliance=body.compliance + more)


@dataclass(frozen=True)
class Backlash(Effect):
    """Gears with play, behind the encoder: the link is free within it, a stiff spring beyond.

    Attributes:
        joints: which ones.
        play: whole width of the dead band, on top of what the reality has [rad].
    """

    joints: Parts
    play: float

    @classmethod
    def read(cls, fields: Fields) -> Backlash:
        """From the item of a reality file."""
        fields.only("effect", "location", "play_rad")
        return cls(Parts.read(fields, "joint"), fields.number("play_rad", minimum=0.0, maximum=0.5))

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        more = self.joints.mask(body.robot) * self.play
        return dataclasses.replace(body, play=body.play + more)


@dataclass(frozen=True)
class FootPlacement(Effect):
    """A shoe that sits askew on the ankle: in the physics, the whole of it.

    Cells, plates and the truth of the CoP go with the true sole frame; joint angles lead to the
    model's.

    Attributes:
        feet: which ones.
        placement: (dx, dy, dtheta) of the true sole frame in the model's [m, m, rad].
    """

    feet: tuple[str, ...]
    placement: tuple[float, float, float]

    @classmethod
    def read(cls, fields: Fields) -> FootPlacement:
        """From the item of a reality file."""
        fields.only("effect", "location", "dx_m", "dy_m", "dtheta_rad")
        return cls(read_feet(fields), read_shift(fields))

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        moved = np.outer([foot in self.feet for foot in FEET], self.placement)
        return dataclasses.replace(body, foot_placement=body.foot_placement + moved)


@dataclass(frozen=True)
class Inertia(Effect):
    """The CoP is the zero-moment point: the physics always has it, so there is nothing to add."""

    @classmethod
    def read(cls, fields: Fields) -> Inertia:
        """From the item of a reality file; its factor can be nothing but 1."""
        fields.only("effect", "location", "factor")
        fields.number("factor", 1.0, minimum=1.0, maximum=1.0)
        return cls()


EFFECTS: dict[str, Callable[[Fields], Effect]] = {
    "total_mass": TotalMass.read,
    "payload": Payload.read,
    "link_com": LinkCom.read,
    "joint_offset": JointOffset.read,
    "joint_compliance": JointCompliance.read,
    "backlash": Backlash.read,
    "foot_placement": FootPlacement.read,
    "inertia": Inertia.read,
}
"""Effects of this family by identifier."""
