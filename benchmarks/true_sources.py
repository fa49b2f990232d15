"""What is truly wrong in a simulated session, by error source: for a budget of the CoP error.

Names are those of docs/reference/effects.md where it has one; sizes are in SI units, and zero
where nothing is wrong. Effects that a reality lists beside are not in here: they are in its file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import yaml

from shoecal_core.recording.session import Session
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe

Source = tuple[str, tuple[str, ...], str]
"""Effect, location, component."""
Drawn = Mapping[str, Any]
"""What truth/reality.yaml holds: numbers, and numbers or lists of them by name."""

JOINTS = {
    ("joint_offset", "angle"): "encoder_error_rad",
    ("joint_compliance", "compliance"): "compliance_rad_per_nm",
    ("backlash", "play"): "play_rad",
}
"""Keys of truth/reality.yaml by effect and component: one number a joint."""
JOINT_PAIRS = {
    ("encoder_eccentricity", ("amplitude", "phase")): "eccentricity_rad",
    ("joint_friction", ("static", "kinetic")): "joint_friction_nm",
}
"""Two numbers a joint; no diagnosis knows these."""
MASSES = ("payload", "shoe_mass")


def read_drawn(session: Session) -> Drawn:
    """Everything that was drawn: truth/reality.yaml."""
    said = yaml.safe_load((session.truth_path(1).parent / "reality.yaml").read_text())
    drawn: Drawn = _with_numbers(said)
    return drawn


def _with_numbers(said: Any) -> Any:
    """The same; YAML 1.1 takes 1e-5 for a text."""
    if isinstance(said, dict):
        return {key: _with_numbers(one) for key, one in said.items()}
    if isinstance(said, list):
        return [_with_numbers(one) for one in said]
    try:
        return float(said) if isinstance(said, str) else said
    except ValueError:
        return said


def true_sources(session: Session) -> dict[Source, float]:
    """True size of each error source of a session.

    Beside the effects of a diagnosis: `plates` (share of a foot's moment that its plates carry past
    the cells), `shoe_mass` (of a shoe's plates, [kg]), `weight` (true minus weighed, shoes included
    [N]), `gain` and `offset` (the true ones), `imu_mounting` (its frame in the root link's).
    `payload` and `link_com` are those of links: the mass that a link has more than the model, at
    the model's CoM, and how far its CoM is off.
    """
    drawn = read_drawn(session)
    found = {
        **dict(_of_joints(drawn)),
        **dict(_of_links(session, drawn)),
        **dict(_of_shoes(session.shoe, drawn)),
    }
    heavier = sum(size for (effect, *_), size in found.items() if effect in MASSES)
    return {**found, ("weight", (), "force"): GRAVITY * heavier}


def _of_joints(drawn: Drawn) -> Iterator[tuple[Source, float]]:
    for (effect, component), key in JOINTS.items():
        for joint, size in drawn[key].items():
            yield (effect, (joint,), component), size
    for (effect, components), key in JOINT_PAIRS.items():
        for joint, sizes in drawn[key].items():
            for component, size in zip(components, sizes, strict=True):
                yield (effect, (joint,), component), size


def _of_links(session: Session, drawn: Drawn) -> Iterator[tuple[Source, float]]:
    model = _link_masses(session)
    factors = drawn["mass_factor"]
    mass_kg = float(drawn["mass_kg"])
    scale = mass_kg / sum(mass * factors[link] for link, mass in model.items())
    for link, mass in model.items():
        payload = mass * (scale * factors[link] - 1.0) + drawn["payload_kg"][link]
        yield ("payload", (link,), "mass"), payload
        for axis, shift in zip("xyz", drawn["com_error_m"][link], strict=True):
            yield ("link_com", (link,), axis), shift
    for axis, angle in zip("xyz", drawn["imu_mounting_rad"], strict=True):
        yield ("imu_mounting", (), f"about_{axis}"), angle


def _link_masses(session: Session) -> dict[str, float]:
    """As the model has them, by name [kg]: the URDF's, scaled to what the robot weighs."""
    links = mujoco.MjSpec.from_file(str(session.robot_urdf)).bodies
    masses = {link.name: float(link.mass) for link in links if link.mass > 0.0}
    shoe = session.shoe
    robot = load_robot(session.robot_yaml, shoe)
    scale = (robot.mass - shoe.mass) / sum(masses.values())
    return {name: scale * mass for name, mass in masses.items()}


def _of_shoes(shoe: Shoe, drawn: Drawn) -> Iterator[tuple[Source, float]]:
    for name, stated in zip(shoe.names, shoe.positions.tolist(), strict=True):
        for axis, true, file in zip("xy", drawn["position_m"][name], stated, strict=True):
            yield ("cell_position", (name,), axis), true - file
        for law in ("gain", "offset"):
            yield (law, (name,), law), drawn[law][name]
        yield ("latency", (name,), "delay"), drawn["latency_s"][name]
    for foot, plates in zip(drawn["clamp_share"], shoe.plates, strict=True):
        for axis in "xy":
            yield ("plates", (foot,), f"share_{axis}"), drawn["clamp_share"][foot]
        mass = plates.mass_above + plates.mass_below
        yield ("shoe_mass", (foot,), "mass"), mass * (drawn["shoe_mass_factor"][foot] - 1.0)
        placement = drawn["foot_placement"][foot]
        for component, size in zip(("dx", "dy", "dtheta"), placement, strict=True):
            yield ("foot_placement", (foot,), component), size
        compliance = drawn["ground_compliance_rad_per_nm"][foot]
        yield ("soft_ground", (foot,), "compliance"), compliance
    for axis, angle in zip("xy", drawn["floor_tilt_rad"], strict=True):
        yield ("floor_tilt", (), f"about_{axis}"), angle
