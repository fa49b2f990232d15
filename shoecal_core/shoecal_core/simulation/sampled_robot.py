"""One robot in one pair of shoes: the numbers that a reality's rules draw for a seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Channel, Shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.simulation.reality import ALL, BASE, NamedNumbers, PlantVariation
from shoecal_core.simulation.sampled_parts import SampledBody, SampledShoes, link_names
from shoecal_core.simulation.temperature import WarmUp


@dataclass(frozen=True)
class SampledRobot:
    """A reality's rules with all that chance decides.

    Attributes:
        rules: what was drawn from.
        seed: it was drawn with.
        body, shoes: the numbers.
    """

    rules: PlantVariation
    seed: int
    body: SampledBody
    shoes: SampledShoes

    def record(self) -> dict[str, object]:
        """All numbers by name, for a YAML file next to the truth of a session."""
        body, shoes = self.body, self.shoes
        return {
            "reality": self.rules.name,
            "seed": self.seed,
            "mass_kg": body.mass,
            "mass_factor": _by_name(body.links, body.mass_factor),
            "com_error_m": _by_name(body.links, body.com_error),
            "payload_kg": _by_name(body.links, body.payload),
            "encoder_error_rad": _by_name(body.joints, body.encoder_error),
            "eccentricity_rad": _by_name(body.joints, body.eccentricity),
            "play_rad": _by_name(body.joints, body.play),
            "compliance_rad_per_nm": _by_name(body.joints, body.compliance),
            "joint_friction_nm": _by_name(body.joints, body.friction),
            "imu_mounting_rad": body.imu_mounting.tolist(),
            "foot_placement": _by_name(FEET, body.foot_placement),
            "position_m": _by_name(shoes.channels, shoes.position),
            "gain": _by_name(shoes.channels, shoes.parameters.gain),
            "offset": _by_name(shoes.channels, shoes.parameters.offset),
            "noise": _by_name(shoes.channels, shoes.noise),
            "latency_s": _by_name(shoes.channels, shoes.latency),
            "shoe_mass_factor": _by_name(FEET, shoes.mass_factor),
            "clamp_share": _by_name(FEET, shoes.clamp_share),
            "floor_tilt_rad": shoes.tilt.tolist(),
            "ground_compliance_rad_per_nm": _by_name(FEET, shoes.ground_compliance),
        }


def draw(rules: PlantVariation, robot: Robot, shoe: Shoe, seed: int) -> SampledRobot:
    """Draw one robot in one pair of shoes; the shoes of a seed are the same on every robot.

    Args:
        rules: of the reality.
        robot: with the shoes on (`load_robot(path, shoe)`).
        shoe: what it wears.
        seed: of all that chance decides here; readings' noise has its own generator.

    Raises:
        FileError: when the reality names a link, joint, foot or channel that there is not.
    """
    return SampledRobot(
        rules, seed, draw_body(rules, robot, shoe, seed), draw_shoes(rules, shoe, seed)
    )


def draw_body(rules: PlantVariation, robot: Robot, shoe: Shoe, seed: int) -> SampledBody:
    """Draw what is particular of the robot, which wears the shoes."""
    rng = np.random.default_rng([seed, 1])
    links = link_names(robot)
    joints = robot.joint_names
    mass = rng.normal(1.0, rules.body.mass_error_std_fraction, len(links))
    com = rng.normal(0.0, rules.body.com_error_std_m, (len(links), 3))
    encoder = rng.normal(0.0, rules.joints.encoder_error_std_rad, len(joints))
    mounting = rng.normal(0.0, rules.imu.mounting_error_std_rad, 3)
    waves = rng.normal(0.0, rules.joints.eccentricity_std_rad, (len(joints), 2))
    spread = math.sqrt(math.log1p(rules.joints.compliance_spread_fraction**2))
    softness = rng.lognormal(-(spread**2) / 2.0, spread, len(joints))
    mass_error = _column(
        _of_links(rules.body.mass_error_fraction, links), links, mass - 1.0, "link"
    )
    encoder = _column(rules.joints.encoder_error_rad, joints, encoder, "joint")
    for motor in robot.shared:
        encoder[motor.joint] = motor.ratio * encoder[motor.leader]
        waves[motor.joint] = 0.0
    body = SampledBody(
        robot=robot,
        mass=robot.mass - shoe.mass + rules.body.weight_error_n / GRAVITY,
        mass_factor=1.0 + mass_error,
        com_error=_of_links(rules.body.com_error_m, links).resolve(links, com, "link"),
        payload=np.zeros(len(links)),
        encoder_error=encoder,
        eccentricity=np.stack((np.hypot(*waves.T), np.arctan2(*waves.T)), axis=1),
        play=_of_legs(rules.joints.play_rad, robot),
        compliance=_of_legs(rules.joints.compliance_rad_per_nm, robot) * softness,
        friction=_friction(rules, robot),
        imu_mounting=mounting,
        foot_placement=np.zeros((len(FEET), 3)),
    )
    for effect in rules.effects:
        body = effect.on_body(body)
    return body


def draw_shoes(rules: PlantVariation, shoe: Shoe, seed: int) -> SampledShoes:
    """Draw what is particular of a pair of shoes."""
    rng = np.random.default_rng([seed, 2])
    cells = rules.cells
    count = len(shoe.channels)
    position = shoe.positions + rng.normal(0.0, cells.position_error_std_m, (count, 2))
    spread = rng.uniform(-1.0, 1.0, count) * cells.gain_spread_fraction
    shift = rng.normal(0.0, cells.offset_std_fraction, count)
    sign = np.where(shoe.polarity == 0, rng.choice((-1, 1), count), shoe.polarity)
    full_scale = np.where(shoe.torque, cells.full_scale_nm, cells.full_scale_n)
    unsaid = full_scale / _half_span(shoe.channels) * (1.0 + spread)
    # What has a data sheet is as it says, give or take.
    sheet = np.array([abs(channel.nominal_gain or 0.0) for channel in shoe.channels])
    error = np.random.default_rng([seed, 5]).normal(0.0, cells.nominal_gain_std_fraction, count)
    gain = sign * np.where(sheet > 0.0, sheet * (1.0 + error), unsaid)
    listed = cells.position_error_m.resolve(shoe.names, position - shoe.positions, "channel")
    ones = np.ones(len(FEET))
    shoes = SampledShoes(
        shoe=shoe,
        position=shoe.positions + listed,
        parameters=ChannelParameters(gain, full_scale * shift),
        noise=np.where(shoe.torque, cells.noise_std_nm, cells.noise_std_n),
        latency=np.zeros(count),
        mass_factor=1.0 + _column(rules.shoes.mass_error_fraction, FEET, 0.0 * ones, "foot"),
        clamp_share=_column(rules.shoes.clamp_share, FEET, 0.0 * ones, "foot"),
        tilt=np.zeros(2),
        ground_compliance=np.zeros(len(FEET)),
        full_scale=full_scale,
        temperature=WarmUp(
            rules.servo.ambient_degc,
            rules.shoes.warm_up_k,
            rules.shoes.warm_up_time_s,
            rules.shoes.temperature_told,
        ),
    )
    for effect in rules.effects:
        shoes = effect.on_shoes(shoes)
    return shoes


def _of_links(table: NamedNumbers, links: tuple[str, ...]) -> NamedNumbers:
    """A table of links, its `base` written as the root link's name."""
    rows = {links[0] if name == BASE else name: row for name, row in table.rows.items()}
    return NamedNumbers(rows, table.path, table.key)


def _column(
    table: NamedNumbers, names: Sequence[str], default: FloatArray, kind: str
) -> FloatArray:
    """(len(names),) of a table that holds one number a name."""
    return table.resolve(names, default[:, None], kind)[:, 0]


def _of_legs(table: NamedNumbers, robot: Robot) -> FloatArray:
    """(m,) of a table whose `all` means the joints of the legs."""
    rows = dict(table.rows)
    common = rows.pop(ALL, (0.0,))
    default = np.zeros(len(robot.joint_names))
    default[robot.moved] = common[0]
    return _column(NamedNumbers(rows, table.path, table.key), robot.joint_names, default, "joint")


def _friction(rules: PlantVariation, robot: Robot) -> FloatArray:
    """(m, 2) static and kinetic friction of the legs' joints [N m]."""
    joints, limits = rules.joints, robot.effort_limit * rules.servo.torque_limit_factor
    shares = np.array([joints.static_friction_fraction, joints.kinetic_friction_fraction])
    friction = np.zeros((len(limits), 2))
    friction[robot.moved] = limits[robot.moved, None] * shares
    return friction


def _half_span(channels: Sequence[Channel]) -> FloatArray:
    return np.array([(channel.highest - channel.lowest) / 2.0 for channel in channels])


def _by_name(names: Sequence[str], values: FloatArray) -> dict[str, object]:
    return dict(zip(names, values.tolist(), strict=True))
