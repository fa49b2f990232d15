"""Lengths, masses and CoMs that no humanoid has: exporters write wrong units, and masses twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.urdf import UrdfError, name_links

LEG_M = (0.03, 3.0)
"""Length of a leg from the hip to the foot: from a toy's to a robot's of twice a man's height."""
MILLIMETRES_FROM = 30.0
"""Length of a leg from which millimetres are likelier than centimetres."""
DENSITY = (5.0, 3000.0)
"""Mass over the cube of the legs' length [kg/m^3]: between 90 and 600 for all humanoids that were
looked at, of 1 to 100 kg."""
SAME_MASS = 0.02
"""By which a frame's mass may differ from that of a whole assembly, as a share of it."""
FAR = 2.0
"""Lengths of a leg between a link's frame and its CoM from which the unit is wrong: CAD programs
give millimetres. A trunk's frame may lie at the feet, a leg's length away."""
FEW = 3
"""Part of the links up to which single masses have the wrong unit, not all of them."""


@dataclass(frozen=True)
class Link:
    """What a URDF says of one link that has a mass.

    Attributes:
        name: of it.
        shaped: it has a shape.
        mass: of it [kg].
        com: (3,) in its frame [m].
        inertia: (3, 3) about the CoM [kg m^2].
    """

    name: str
    shaped: bool
    mass: float
    com: FloatArray
    inertia: FloatArray


def check_links(urdf: Path, links: Sequence[Link], length: float) -> None:
    """Refuse what contradicts itself: nothing that is computed with it would be right.

    Args:
        urdf: the file, for messages.
        links: all that have a mass.
        length: of a leg from joint to joint [m].

    Raises:
        UrdfError: for legs that are too long or too short, masses and CoMs that do not go with
            them, and frames that have the mass of the whole robot once more.
    """
    if not LEG_M[0] < length < LEG_M[1]:
        unit = "mm" if length > MILLIMETRES_FROM else "cm" if length > 1.0 else "km"
        raise UrdfError(
            urdf,
            f"the legs are {length:.3g} m long: are the lengths in {unit}? Give them in m",
            field="joint origins",
        )
    mass = sum(link.mass for link in links)
    low, high = (one * length**3 for one in DENSITY)
    if not low < mass < high:
        unit = "g" if mass > high else "t"
        heavy = _too_heavy(links, high)
        raise UrdfError(
            urdf,
            f"{mass:.4g} kg on legs of {length:.2f} m"
            + (
                f", {sum(link.mass for link in heavy):.4g} kg of them in {named(heavy)}: "
                f"is it in {unit}? "
                if heavy
                else f": are the masses in {unit}? "
            )
            + "Give them in kg",
            field=f"link {heavy[0].name}" if heavy else "mass",
        )
    far = [link for link in links if np.linalg.norm(link.com) > FAR * length]
    if far:
        raise UrdfError(
            urdf,
            f"the CoM of {named(far)} is {np.linalg.norm(far[0].com):.3g} m from the link's "
            f"frame, on legs of {length:.2f} m: is <origin> of its <inertial> in mm? Give m",
            field=f"link {far[0].name}",
        )
    shapeless = [link for link in links if not link.shaped]
    # Of a model without any shapes that says nothing: a trunk may have half the mass.
    for one in shapeless if len(shapeless) < len(links) else ():
        alike = [link for link in shapeless if abs(link.mass - one.mass) < SAME_MASS * one.mass]
        rest = mass - sum(link.mass for link in alike)
        if abs(rest - one.mass) < SAME_MASS * one.mass:
            raise UrdfError(
                urdf,
                f"{named(alike)}: no shape, and {one.mass:.3g} kg"
                f"{' each' if alike[1:] else ''}, as much as all other links together: "
                "exported with the mass of the whole robot? Delete the <inertial>",
                field=f"link {alike[0].name}",
            )


def read_links(root: ElementTree.Element) -> list[Link]:
    """All that have a mass, of the elements of a URDF.

    What is no number somewhere in an <inertial> leaves the link out: the parser of URDFs does so.
    """
    return [link for element in root.iter("link") if (link := _read_link(element)) is not None]


def _read_link(link: ElementTree.Element) -> Link | None:
    mass, origin = link.find("inertial/mass"), link.find("inertial/origin")
    if mass is None:
        return None
    place = (origin.get("xyz") if origin is not None else None) or "0 0 0"
    try:
        return Link(
            link.get("name", ""),
            link.find("collision") is not None or link.find("visual") is not None,
            float(mass.get("value", "")),
            np.array([float(part) for part in place.split()]),
            _inertia(link.find("inertial/inertia")),
        )
    except ValueError:
        return None


def _inertia(element: ElementTree.Element | None) -> FloatArray:
    """(3, 3) of a link about its CoM [kg m^2]."""
    rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
    given = element.attrib if element is not None else {}
    return np.array([[float(given.get(key, "0")) for key in row] for row in rows])


def _too_heavy(links: Sequence[Link], high: float) -> list[Link]:
    """Those without which the rest is a robot; none where all masses have the wrong unit."""
    order = sorted(links, key=lambda link: -link.mass)
    rest = sum(link.mass for link in order)
    for count, link in enumerate(order[: len(order) // FEW], start=1):
        rest -= link.mass
        if rest < high and link.mass > high:
            return list(order[:count])
    return []


def named(links: Sequence[Link]) -> str:
    """Their names, in words."""
    return name_links([link.name for link in links])
