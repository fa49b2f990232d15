"""What no humanoid has: exporters write wrong units, masses twice, and limits of the other leg."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.robot.leg_masses import NOTABLE, unlike_masses
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
HEAVY = 0.3
"""Share of the robot's mass from which a link without a shape is looked at."""
FAR = 2.0
"""Lengths of a leg between a link's frame and its CoM from which the unit is wrong: CAD programs
give millimetres. A trunk's frame may lie at the feet, a leg's length away."""
GYRATION = 1.0
"""Lengths of a leg from which a radius of gyration has another unit: no link is as large."""
FEW = 3
"""Part of the links up to which single masses have the wrong unit, not all of them."""
EQUAL_MASSES = 0.9
"""Share of the links with mass from which one mass in all of them is an exporter's default."""
PARALLEL = 0.9
"""Cosine of the angle between an axis and the other one's mirror image, at least."""
SAME_LIMIT = 0.05
"""rad; limits that are off by less are the same."""


@dataclass(frozen=True)
class _Link:
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


def check_size(body: Body, legs: LegChains) -> None:
    """Refuse what contradicts itself: nothing that is computed with it would be right.

    Raises:
        UrdfError: for legs that are too long or too short, masses and CoMs that do not go with
            them, and frames that have the mass of the whole robot once more.
    """
    length = _leg_length(body, legs)
    if not LEG_M[0] < length < LEG_M[1]:
        unit = "mm" if length > MILLIMETRES_FROM else "cm" if length > 1.0 else "km"
        raise UrdfError(
            body.urdf,
            f"the legs are {length:.3g} m long: are the lengths in {unit}? Give them in m",
            field="joint origins",
        )
    links = _links(body.root)
    mass = sum(link.mass for link in links)
    low, high = (one * length**3 for one in DENSITY)
    if not low < mass < high:
        unit = "g" if mass > high else "t"
        heavy = _too_heavy(links, high)
        raise UrdfError(
            body.urdf,
            f"{mass:.4g} kg on legs of {length:.2f} m"
            + (
                f", {sum(link.mass for link in heavy):.4g} kg of them in {_named(heavy)}: "
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
            body.urdf,
            f"the CoM of {_named(far)} is {np.linalg.norm(far[0].com):.3g} m from the link's "
            f"frame, on legs of {length:.2f} m: is <origin> of its <inertial> in mm? Give m",
            field=f"link {far[0].name}",
        )
    shapeless = [link for link in links if not link.shaped]
    for one in shapeless:
        alike = [link for link in shapeless if abs(link.mass - one.mass) < SAME_MASS * one.mass]
        rest = mass - sum(link.mass for link in alike)
        if abs(rest - one.mass) < SAME_MASS * one.mass:
            raise UrdfError(
                body.urdf,
                f"{_named(alike)}: no shape, and {one.mass:.3g} kg"
                f"{' each' if alike[1:] else ''}, as much as all other links together: "
                "exported with the mass of the whole robot? Delete the <inertial>",
                field=f"link {alike[0].name}",
            )


def doubts(body: Body, legs: LegChains) -> Iterator[str]:
    """Masses and inertias that may be right and mostly are not, in words."""
    links, length = _links(body.root), _leg_length(body, legs)
    total = sum(link.mass for link in links)
    for link in links if any(one.shaped for one in links) else ():
        if not link.shaped and link.mass > HEAVY * total:
            share = link.mass / total
            yield f"{link.name} has no shape and {link.mass:.3g} kg, {share:.0%} of the robot"
    ((mass, count),) = Counter(link.mass for link in links).most_common(1)
    if count > EQUAL_MASSES * len(links) > 1.0:
        yield f"{count} of {len(links)} links have {mass:.3g} kg each, an exporter's default"
    impossible = [link for link in links if np.linalg.eigvalsh(link.inertia)[0] < 0.0]
    if impossible:
        yield f"no body has a moment of inertia below zero, as {_named(impossible)} would"
    wide = [
        link
        for link in links
        if link.mass > NOTABLE * total
        and np.trace(link.inertia) > 2.0 * link.mass * (GYRATION * length) ** 2
    ]
    if wide:
        yield f"the inertia of {_named(wide)} is that of a larger body, in kg mm^2 perhaps"
    for left, right, masses in unlike_masses(body.model, zip(*legs.chains, strict=True), total):
        names = " and ".join(body.link(joint)[0] for joint in (left, right))
        yield f"{names} are {masses[0]:.3g} and {masses[1]:.3g} kg, though the legs are alike"


def crossed_limits(body: Body, legs: LegChains) -> list[tuple[int, int]]:
    """Joints of the left and the right leg whose limits fit each other with the wrong sign.

    The exporter of a mirrored leg has turned its axes but not its limits, or the other way round.
    """
    return [pair for pair in zip(*legs.chains, strict=True) if _crossed(body, legs, *pair)]


def _leg_length(body: Body, legs: LegChains) -> float:
    """From joint to joint [m]."""
    steps = itertools.pairwise(body.centres[joint] for joint in legs.chains[0])
    return float(sum(np.linalg.norm(after - before) for before, after in steps))


def _links(root: ElementTree.Element) -> list[_Link]:
    """All that have a mass; NaN where something is missing."""
    return [
        _Link(
            link.get("name", ""),
            link.find("collision") is not None or link.find("visual") is not None,
            float(mass.get("value", "nan")),
            _com(link.find("inertial/origin")),
            _inertia(link.find("inertial/inertia")),
        )
        for link in root.iter("link")
        if (mass := link.find("inertial/mass")) is not None
    ]


def _com(origin: ElementTree.Element | None) -> FloatArray:
    """(3,) of a link in its frame [m]."""
    place = (origin.get("xyz") if origin is not None else None) or "0 0 0"
    return np.array([float(part) for part in place.split()])


def _inertia(element: ElementTree.Element | None) -> FloatArray:
    """(3, 3) of a link about its CoM [kg m^2]."""
    rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
    given = element.attrib if element is not None else {}
    return np.array([[float(given.get(key, "0")) for key in row] for row in rows])


def _too_heavy(links: list[_Link], high: float) -> list[_Link]:
    """Those without which the rest is a robot; none where all masses have the wrong unit."""
    order = sorted(links, key=lambda link: -link.mass)
    rest = sum(link.mass for link in order)
    for count, link in enumerate(order[: len(order) // FEW], start=1):
        rest -= link.mass
        if rest < high and link.mass > high:
            return order[:count]
    return []


def _named(links: list[_Link]) -> str:
    return name_links([link.name for link in links])


def _crossed(body: Body, legs: LegChains, left: int, right: int) -> bool:
    turn = body.axis(left)
    # The mirror image of a turn: what lies in the mirror changes its sign, what is across does not.
    mirrored = 2.0 * (turn @ legs.left) * legs.left - turn
    along = float(mirrored @ body.axis(right))
    if abs(along) < PARALLEL:
        return False
    ours, theirs = np.array(body.range(left)), np.array(body.range(right))
    alike, crossed = (theirs, -theirs[::-1]) if along > 0.0 else (-theirs[::-1], theirs)
    return not _same(ours, alike) and _same(ours, crossed)


def _same(ours: FloatArray, theirs: FloatArray) -> bool:
    return bool(np.abs(ours - theirs).max() < SAME_LIMIT)
