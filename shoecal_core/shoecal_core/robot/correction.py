"""Joint zeros, masses and centres of mass that were found, as a changed copy of a URDF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.urdf import move_zero, written


@dataclass(frozen=True)
class ModelCorrection:
    """How a robot is off its URDF; what is fixed to a link is part of it.

    Attributes:
        zeros: by joint, how much more its encoder shows than the link has turned [rad].
        masses: by link, what it weighs by what the URDF says.
        coms: by link, (3,) how far its CoM is from where the URDF has it, link's frame [m].
        compliance: by joint, of what is between its encoder and its link [rad/(N m)].
        play: by joint, the whole dead band between them [rad].
        latency: by foot, age of its readings [s].

    A URDF has no place for the last three.
    """

    zeros: Mapping[str, float]
    masses: Mapping[str, float]
    coms: Mapping[str, FloatArray]
    compliance: Mapping[str, float] = field(default_factory=dict)
    play: Mapping[str, float] = field(default_factory=dict)
    latency: Mapping[str, float] = field(default_factory=dict)


def corrected_urdf(text: str, robot: Robot, correction: ModelCorrection) -> str:
    """A URDF of the same robot with what was found; limits of joints stay as they are.

    Args:
        text: XML without a document type.
        robot: made of it.
        correction: links named by the first of those that are fixed to each other.
    """
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))  # noqa: S314 - document types have been refused
    root = ElementTree.fromstring(text, parser)  # noqa: S314
    for joint in root.iter("joint"):
        if zero := correction.zeros.get(joint.get("name", ""), 0.0):
            move_zero(joint, -zero)
    placed = {frame.name: frame for frame in robot.model.frames if frame.type == pin.FrameType.BODY}
    for link in root.iter("link"):
        frame, inertial = placed.get(link.get("name", "")), link.find("inertial")
        if frame is None or inertial is None:
            continue
        leading = first_link(robot.model, frame.parentJoint)
        _weigh(inertial, correction.masses.get(leading.name, 1.0))
        if (moved := correction.coms.get(leading.name)) is not None:
            turned = frame.placement.rotation.T @ leading.placement.rotation
            _move(inertial, turned @ moved)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _weigh(inertial: ElementTree.Element, factor: float) -> None:
    """Mass and, its shape being the same, moments of inertia times a factor."""
    for tag in ("mass", "inertia"):
        part = inertial.find(tag)
        if part is not None and factor != 1.0:
            for name, value in part.attrib.items():
                part.set(name, written(np.array([float(value) * factor])))


def _move(inertial: ElementTree.Element, moved: FloatArray) -> None:
    origin = inertial.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(inertial, "origin")
    place = np.array(origin.get("xyz", "0 0 0").split(), dtype=np.float64)
    origin.set("xyz", written(place + moved))
