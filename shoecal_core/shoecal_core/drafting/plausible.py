"""What no humanoid has: exporters write wrong units, masses twice, and limits of the other leg."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.robot.urdf import UrdfError

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
UNLIKE = 1.9
"""Times the mass of its counterpart in the other leg from which a link is looked at: doubled, or
half of it, both rounded."""
NOTABLE = 0.02
"""Share of the robot's mass from which such a difference matters."""
PARALLEL = 0.9
"""Cosine of the angle between an axis and the other one's mirror image, at least."""
SAME_LIMIT = 0.05
"""rad; limits that are off by less are the same."""


def check_size(body: Body, legs: LegChains) -> None:
    """Refuse what contradicts itself: nothing that is computed with it would be right.

    Raises:
        UrdfError: for legs that are too long or too short, masses that do not go with them, and
            frames that have the mass of the whole robot once more.
    """
    length = _leg_length(body, legs)
    if not LEG_M[0] < length < LEG_M[1]:
        unit = "mm" if length > MILLIMETRES_FROM else "cm" if length > 1.0 else "km"
        raise UrdfError(
            body.urdf,
            f"the legs are {length:.3g} m long: are the lengths in {unit}? Give them in m",
            field="joint origins",
        )
    mass = sum(inertia.mass for inertia in body.model.inertias)
    low, high = (one * length**3 for one in DENSITY)
    if not low < mass < high:
        unit = "g" if mass > high else "t"
        raise UrdfError(
            body.urdf,
            f"{mass:.4g} kg on legs of {length:.2f} m: are the masses in {unit}? Give them in kg",
            field="mass",
        )
    shaped, shapeless = _masses(body.root)
    whole = sum((shaped | shapeless).values())
    for mass in shapeless.values():
        alike = [name for name, own in shapeless.items() if abs(own - mass) < SAME_MASS * mass]
        rest = whole - sum(shapeless[name] for name in alike)
        if abs(rest - mass) < SAME_MASS * mass:
            raise UrdfError(
                body.urdf,
                f"{' and '.join(alike)}: no shape, and {mass:.3g} kg"
                f"{' each' if alike[1:] else ''}, as much as all other links together: "
                "exported with the mass of the whole robot? Delete the <inertial>",
                field=f"link {alike[0]}",
            )


def doubts(body: Body, legs: LegChains) -> Iterator[str]:
    """Masses that may be right and mostly are not, in words."""
    model = body.model
    total = sum(inertia.mass for inertia in model.inertias)
    shaped, shapeless = _masses(body.root)
    for name, mass in shapeless.items() if shaped else ():
        if mass > HEAVY * total:
            yield f"{name} has no shape and {mass:.3g} kg, {mass / total:.0%} of the robot"
    for left, right in zip(*legs.chains, strict=True):
        low, high = sorted((model.inertias[left].mass, model.inertias[right].mass))
        if high > UNLIKE * low and high - low > NOTABLE * total:
            names = " and ".join(body.link(joint)[0] for joint in (left, right))
            yield f"{names} are {low:.3g} and {high:.3g} kg, though the legs are alike"


def crossed_limits(body: Body, legs: LegChains) -> list[tuple[int, int]]:
    """Joints of the left and the right leg whose limits fit each other with the wrong sign.

    The exporter of a mirrored leg has turned its axes but not its limits, or the other way round.
    """
    return [pair for pair in zip(*legs.chains, strict=True) if _crossed(body, legs, *pair)]


def _leg_length(body: Body, legs: LegChains) -> float:
    """From joint to joint [m]."""
    steps = itertools.pairwise(body.centres[joint] for joint in legs.chains[0])
    return float(sum(np.linalg.norm(after - before) for before, after in steps))


def _masses(root: ElementTree.Element) -> tuple[dict[str, float], dict[str, float]]:
    """Of links with a shape, and of those without [kg]."""
    found: tuple[dict[str, float], dict[str, float]] = ({}, {})
    for link in root.iter("link"):
        mass = link.find("inertial/mass")
        shapeless = link.find("collision") is None and link.find("visual") is None
        if mass is not None:
            found[shapeless][link.get("name", "")] = float(mass.get("value", "nan"))
    return found


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
