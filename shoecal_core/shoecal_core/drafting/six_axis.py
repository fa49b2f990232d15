"""Six-axis force sensors that a URDF names in the feet."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.drafting.soles import Sole

NAME = re.compile(
    r"(^|[_\-/.])(ft|fts|f_t|force_?torque|wrench)([_\-/.]|$)|force_?torque", re.IGNORECASE
)
PARALLEL = np.radians(2.0)


@dataclass(frozen=True)
class SixAxis:
    """The sensor of one foot, in its sole frame.

    Attributes:
        name: of the joint or link that is it.
        origin: (3,) [m].
        signs: (3,) +1 or -1: its axes along or against the sole's; None where they are neither.
    """

    name: str
    origin: FloatArray
    signs: tuple[int, int, int] | None


def find_six_axis(body: Body, legs: LegChains, soles: tuple[Sole, Sole]) -> list[SixAxis | None]:
    """Left and right: the sensor that turns with the foot, the highest of several.

    Those that a `<sensor type="force_torque">` declares count before those that are sensors by
    their names alone: names with `ft` in them are also those of gyroscopes next to a sensor.
    """
    found = []
    for chain, sole in zip(legs.chains, soles, strict=True):
        declared = _declared_on_foot(body, chain[-1], sole)
        sensors = declared or _named_on_foot(body, chain[-1], sole)
        found.append(max(sensors, key=lambda sensor: sensor.origin[2], default=None))
    return found


def more_on_feet(body: Body, legs: LegChains, soles: tuple[Sole, Sole]) -> list[str]:
    """Declared sensors of feet that have several, where each carries a part of the load."""
    return sorted(
        sensor.name
        for chain, sole in zip(legs.chains, soles, strict=True)
        if len(declared := _declared_on_foot(body, chain[-1], sole)) > 1
        for sensor in declared
    )


def at_ankles(body: Body, legs: LegChains, soles: tuple[Sole, Sole]) -> list[SixAxis | None]:
    """Sensors that the URDF does not name, at the last joints, axes as the soles'."""
    return [
        SixAxis(str(body.model.names[chain[-1]]), np.array([0.0, 0.0, sole.height]), (1, 1, 1))
        for chain, sole in zip(legs.chains, soles, strict=True)
    ]


def elsewhere(body: Body, legs: LegChains) -> list[str]:
    """Sensors of the legs that do not turn with the foot; by their names where none is declared."""
    declared = {name for name, _ in _declared(body)}
    inner = {joint for chain in legs.chains for joint in chain[:-1]}
    fixed = [
        frame
        for frame in body.model.frames
        if frame.type == pin.FrameType.FIXED_JOINT and frame.parentJoint in inner
    ]
    names = declared or _named(body)
    return sorted(str(frame.name) for frame in fixed if frame.name in names)


def _declared(body: Body) -> list[tuple[str, pin.SE3]]:
    """Joints (and links) that a force-torque sensor is declared on, and its pose in their child."""
    found = [
        (element.get("reference", ""), _pose(sensor.findtext("pose", "")))
        for element in body.root.iter("gazebo")
        for sensor in element.iterfind("sensor[@type='force_torque']")
    ]
    for sensor in body.root.iterfind("sensor[@type='force_torque']"):
        parent, origin = sensor.find("parent"), sensor.find("origin")
        if parent is not None:
            name = parent.get("joint") or parent.get("link") or ""
            text = "" if origin is None else f"{origin.get('xyz', '')} {origin.get('rpy', '')}"
            found.append((name, _pose(text)))
    return [(name, pose) for name, pose in found if name]


def _pose(text: str) -> pin.SE3:
    """From `x y z roll pitch yaw`; no displacement where it is something else."""
    try:
        numbers = np.array([float(part) for part in text.split()])
    except ValueError:
        numbers = np.zeros(0)
    if len(numbers) != 6 or not np.isfinite(numbers).all():
        return pin.SE3.Identity()
    return pin.SE3(pin.rpy.rpyToMatrix(*numbers[3:]), numbers[:3])


def _named(body: Body) -> set[str]:
    """Fixed joints that are sensors by their own name or their link's."""
    names = set()
    for joint in body.root.iter("joint"):
        child = joint.find("child")
        both = (joint.get("name", ""), "" if child is None else child.get("link", ""))
        if joint.get("type") == "fixed" and any(map(NAME.search, both)):
            names.add(both[0])
    return names


def _declared_on_foot(body: Body, joint: int, sole: Sole) -> list[SixAxis]:
    """Each once: a URDF may declare one for Gazebo and for others."""
    found: dict[str, SixAxis] = {}
    for name, pose in _declared(body):
        frame = _frame(body, name, joint)
        if frame is not None:
            found.setdefault(name, _in_sole(body, joint, sole, name, frame * pose))
    return list(found.values())


def _frame(body: Body, name: str, joint: int) -> pin.SE3 | None:
    """A frame of the foot in its joint's frame; None for one that is elsewhere."""
    model = body.model
    if name == model.names[joint]:
        return body.link(joint)[1]
    for frame in model.frames:
        if frame.name == name and frame.parentJoint == joint:
            return pin.SE3(frame.placement)
    return None


def _named_on_foot(body: Body, joint: int, sole: Sole) -> list[SixAxis]:
    names = _named(body)
    return [
        _in_sole(body, joint, sole, str(frame.name), frame.placement)
        for frame in body.model.frames
        if frame.type == pin.FrameType.FIXED_JOINT
        and frame.name in names
        and frame.parentJoint == joint
    ]


def _in_sole(body: Body, joint: int, sole: Sole, name: str, frame: pin.SE3) -> SixAxis:
    in_sole = sole.in_base.actInv(body.placements[joint] * frame)
    return SixAxis(name, in_sole.translation, _signs(in_sole.rotation))


def _signs(rotation: FloatArray) -> tuple[int, int, int] | None:
    """Which way each axis points, where every one lies along its namesake of the sole."""
    diagonal = np.diag(rotation)
    if np.abs(diagonal).min() < np.cos(PARALLEL):
        return None
    x, y, z = (int(np.sign(value)) for value in diagonal)
    return x, y, z
