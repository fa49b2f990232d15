"""What distinguishes the simulated world from its model: every cause by name, as rules.

The rules hold no chance: `drawn.draw` turns them into the numbers of one robot in one pair of
shoes. Every field is a key of a reality file, documented in `config/realities/default.yaml`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, instead
from shoecal_core.simulation.effects.effect import Effect

ALL = "all"
BASE = "base"
"""Stands for the robot's root link in a table of links."""


@dataclass(frozen=True)
class NamedNumbers:
    """Numbers by name; `all` stands for every name that is not listed.

    Attributes:
        rows: name to numbers.
        path, key: where they were written, for messages.
    """

    rows: Mapping[str, tuple[float, ...]]
    path: Path
    key: str

    def resolve(self, names: Sequence[str], default: FloatArray, kind: str) -> FloatArray:
        """(k, width) the numbers of each of k names.

        Args:
            names: the names that exist.
            default: (k, width) for names that the table says nothing of.
            kind: what the names are, for messages.

        Raises:
            FieldError: when the table holds a name that does not exist.
        """
        for name in self.rows:
            if name != ALL and name not in names:
                raise FieldError(
                    self.path,
                    f"there is no {kind} '{name}' ({instead(name, names)})",
                    field=self.key,
                )
        resolved = np.array(default, dtype=np.float64)
        for index, name in enumerate(names):
            row = self.rows.get(name, self.rows.get(ALL))
            if row is not None:
                resolved[index] = row
        return resolved


@dataclass(frozen=True)
class Bounds:
    """Where a number may lie; a table's rows have `width` of them."""

    minimum: float = -math.inf
    above: float = -math.inf
    maximum: float = math.inf
    width: int = 1


@dataclass(frozen=True)
class Choices:
    """Words of which one is to be chosen."""

    words: tuple[str, ...]


Number = Annotated[float, Bounds()]
NonNegative = Annotated[float, Bounds(minimum=0.0)]
Positive = Annotated[float, Bounds(above=0.0)]
Fraction = Annotated[float, Bounds(minimum=0.0, maximum=0.9)]
Errors = Annotated[NamedNumbers, Bounds()]
RelativeErrors = Annotated[NamedNumbers, Bounds(minimum=-0.9)]
NonNegatives = Annotated[NamedNumbers, Bounds(minimum=0.0)]


INTEGRATORS = ("discrete", "implicit", "implicitfast", "euler")
CONES = ("elliptic", "pyramidal")


@dataclass(frozen=True)
class EngineRules:
    """How the physics is computed."""

    integrator: Annotated[str, Choices(INTEGRATORS)]
    cone: Annotated[str, Choices(CONES)]
    sideways_ratio: Positive


@dataclass(frozen=True)
class BodyRules:
    """Masses of the robot's links."""

    weight_error_n: Number
    mass_error_std_fraction: Fraction
    mass_error_fraction: RelativeErrors
    com_error_std_m: NonNegative
    com_error_m: Annotated[NamedNumbers, Bounds(width=3)]


@dataclass(frozen=True)
class JointRules:
    """Encoders, and what lies between motor and link."""

    encoder_error_std_rad: NonNegative
    encoder_error_rad: Errors
    encoder_resolution_rad: NonNegative
    eccentricity_std_rad: Annotated[float, Bounds(minimum=0.0, maximum=0.1)]
    play_rad: NonNegatives
    compliance_rad_per_nm: NonNegatives
    compliance_spread_fraction: Annotated[float, Bounds(minimum=0.0, maximum=2.0)]
    static_friction_fraction: Fraction
    kinetic_friction_fraction: Fraction
    stribeck_speed_rad_per_s: Positive


@dataclass(frozen=True)
class ServoRules:
    """Position control of the motors; torque limits are those of the URDF."""

    torque_limit_factor: Positive
    full_torque_error_rad: Positive
    damping_time_s: NonNegative
    friction_fraction: Fraction
    rotor_inertia_kgm2_per_nm: Positive
    temperature_rise_degc: NonNegative
    temperature_time_s: Positive
    ambient_degc: Number
    temperatures_told: bool


@dataclass(frozen=True)
class ImuRules:
    """The inertial sensor at the root link."""

    present: bool
    mounting_error_std_rad: NonNegative
    orientation_std_rad: NonNegative
    gyro_std_rad_per_s: NonNegative
    accelerometer_std_mps2: NonNegative


@dataclass(frozen=True)
class CellRules:
    """Force channels, from the force to the reading."""

    stiffness_n_per_m: Positive
    damping_time_s: NonNegative
    height_m: NonNegative
    position_error_std_m: NonNegative
    position_error_m: Annotated[NamedNumbers, Bounds(width=2)]
    full_scale_n: Positive
    full_scale_nm: Positive
    gain_spread_fraction: Fraction
    nominal_gain_std_fraction: NonNegative
    offset_std_fraction: Fraction
    noise_std_n: NonNegative
    noise_std_nm: NonNegative
    converter_bits: Annotated[int, Bounds(minimum=4, maximum=32)]


@dataclass(frozen=True)
class ShoeRules:
    """Plates of the shoes, and their temperature."""

    mass_error_fraction: RelativeErrors
    clamp_share: Annotated[NamedNumbers, Bounds(minimum=0.0, maximum=0.9)]
    warm_up_k: Number
    warm_up_time_s: Positive
    temperature_told: bool


@dataclass(frozen=True)
class FloorRules:
    """Contact of the shoes with the floor."""

    friction: Positive
    contact_time_s: Positive


@dataclass(frozen=True)
class RigRules:
    """The bench on which a shoe is loaded by hand."""

    placement_error_std_m: NonNegative


@dataclass(frozen=True)
class PlantVariation:
    """Everything in which the simulated world differs from its model."""

    name: str
    step_s: Annotated[float, Bounds(above=0.0, maximum=0.01)]
    engine: EngineRules
    body: BodyRules
    joints: JointRules
    servo: ServoRules
    imu: ImuRules
    cells: CellRules
    shoes: ShoeRules
    floor: FloorRules
    rig: RigRules
    effects: tuple[Effect, ...]
