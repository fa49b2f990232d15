"""Reading a URDF into a Pinocchio model on a free-flying base, and refusing half of one.

The URDF parser drops an inertial that it cannot read, and links that hang on nothing, with no
more than a line on stderr. The CoM would be wrong, so the masses are counted again here.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.parsers import expat

import numpy as np
import pinocchio as pin

from shoecal_core.errors import FileError
from shoecal_core.files import read_bytes
from shoecal_core.model.symbolic import joint_axis

ROOT_JOINTS = 2
"""Pinocchio's universe and free-flyer stand before the robot's own joints."""
MAX_MASS = 1e4
"""kg; no link of a robot weighs more."""


def read_urdf(path: Path) -> pin.Model:
    """Model of a URDF on a free-flying base, masses as they stand there.

    Raises:
        FileError: for anything that is not understood whole.
    """
    text = read_bytes(path).decode("utf-8", errors="replace")
    if "<robot" not in text:
        raise FileError(path, "not a URDF (no <robot> element)")
    declared = sum(_masses(path, text).values())
    try:
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError, IndexError) as error:
        reason = str(error).splitlines()[0] if str(error) else "rejected by the parser"
        raise FileError(path, f"not a usable URDF: {reason}") from error
    understood = sum(inertia.mass for inertia in model.inertias)
    if abs(understood - declared) > 1e-9 * declared:
        raise FileError(
            path,
            f"only {understood:g} of the links' {declared:g} kg are understood; check every "
            "link's inertial, and that every link hangs on the base",
            field="inertial",
        )
    if not declared > 0.0:
        raise FileError(path, "no link has a mass; the CoM needs them", field="inertial")
    _check_joints(path, model)
    return model


def _check_joints(path: Path, model: pin.Model) -> None:
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    for index in range(ROOT_JOINTS, model.njoints):
        field = f"joint {model.names[index]}"
        joint = model.joints[index]
        if joint.nq != 1:
            raise FileError(
                path, "only revolute and prismatic joints with limits are understood", field=field
            )
        if not np.linalg.norm(joint_axis(model, index)) > 0.5:
            raise FileError(path, "its axis has no direction", field=field)
        low, high = lower[joint.idx_q], upper[joint.idx_q]
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise FileError(
                path,
                f"limits {low:g} to {high:g} are missing or crossed; give lower < upper",
                field=field,
            )


def _masses(path: Path, text: str) -> dict[str, float]:
    """Mass of each link as it is written down [kg]."""
    masses: dict[str, float] = {}
    place: list[str] = []
    link = ""

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal link
        place.append(tag)
        if place == ["robot", "link"]:
            link = attributes.get("name", "")
        if place == ["robot", "link", "inertial", "mass"]:
            masses[link] = _mass(path, link, attributes.get("value", ""))

    def refuse(*_: object) -> None:
        raise FileError(path, "declares a document type; leave <!DOCTYPE> out")

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: place.pop()
    # Entities can unfold a small file into gigabytes.
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise FileError(path, f"not valid XML: {error}") from error
    return masses


def _mass(path: Path, link: str, text: str) -> float:
    try:
        mass = float(text)
    except ValueError:
        mass = math.nan
    if not 0.0 <= mass <= MAX_MASS:
        raise FileError(
            path, f"mass '{text[:30]}' is not a number of kg, zero or more", field=f"link {link}"
        )
    return mass
