"""Six-axis force sensors that a URDF names in the feet."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import Legs
from shoecal_core.drafting.soles import Sole

FloatArray = NDArray[np.float64]

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


def find_six_axis(body: Body, legs: Legs, soles: tuple[Sole, Sole]) -> list[SixAxis | None]:
    """Left and right: the named sensor that turns with the foot; the highest of several."""
    names = _named(body)
    return [
        _of_foot(body, names, chain[-1], sole)
        for chain, sole in zip(legs.chains, soles, strict=True)
    ]


def at_ankles(body: Body, legs: Legs, soles: tuple[Sole, Sole]) -> list[SixAxis | None]:
    """Sensors that the URDF does not name, at the last joints, axes as the soles'."""
    return [
        SixAxis(str(body.model.names[chain[-1]]), np.array([0.0, 0.0, sole.height]), (1, 1, 1))
        for chain, sole in zip(legs.chains, soles, strict=True)
    ]


def elsewhere(body: Body, legs: Legs) -> list[str]:
    """Named sensors of the legs that do not turn with the foot."""
    names = _named(body)
    inner = {joint for chain in legs.chains for joint in chain[:-1]}
    return sorted(
        str(frame.name)
        for frame in body.model.frames
        if frame.type == pin.FrameType.FIXED_JOINT
        and frame.name in names
        and frame.parentJoint in inner
    )


def _named(body: Body) -> set[str]:
    """Fixed joints that are sensors by their own name, their link's, or a <sensor> on them."""
    told = {
        element.get("reference", "")
        for element in body.root.iter("gazebo")
        if element.find("sensor[@type='force_torque']") is not None
    }
    for sensor in body.root.iter("sensor"):
        parent = sensor.find("parent")
        if sensor.get("type") == "force_torque" and parent is not None:
            told |= {parent.get("joint", ""), parent.get("link", "")}
    names = set()
    for joint in body.root.iter("joint"):
        child = joint.find("child")
        both = (joint.get("name", ""), "" if child is None else child.get("link", ""))
        if joint.get("type") == "fixed" and (told & {*both} - {""} or any(map(NAME.search, both))):
            names.add(both[0])
    return names


def _of_foot(body: Body, names: set[str], joint: int, sole: Sole) -> SixAxis | None:
    placement = body.placements[joint]
    found = []
    for frame in body.model.frames:
        if (
            frame.type == pin.FrameType.FIXED_JOINT
            and frame.name in names
            and frame.parentJoint == joint
        ):
            in_sole = sole.in_base.actInv(placement * frame.placement)
            found.append(SixAxis(str(frame.name), in_sole.translation, _signs(in_sole.rotation)))
    return max(found, key=lambda sensor: sensor.origin[2]) if found else None


def _signs(rotation: FloatArray) -> tuple[int, int, int] | None:
    """Which way each axis points, where every one lies along its namesake of the sole."""
    diagonal = np.diag(rotation)
    if np.abs(diagonal).min() < np.cos(PARALLEL):
        return None
    x, y, z = (int(np.sign(value)) for value in diagonal)
    return x, y, z
