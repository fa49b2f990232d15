"""What no humanoid has: exporters write wrong units, masses twice, and limits of the other leg."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.robot.joint_centres import leg_length
from shoecal_core.robot.leg_masses import NOTABLE, unlike_masses
from shoecal_core.robot.plausible_links import check_links, named, read_links
from shoecal_core.robot.urdf import name_links

HEAVY = 0.3
"""Share of the robot's mass from which a link without a shape is looked at."""
GYRATION = 1.0
"""Lengths of a leg from which a radius of gyration has another unit: no link is as large."""
EQUAL_MASSES = 0.9
"""Share of the links with mass from which one mass in all of them is an exporter's default."""
PARALLEL = 0.9
"""Cosine of the angle between an axis and the other one's mirror image, at least."""
SAME_LIMIT = 0.05
"""rad; limits that are off by less are the same."""


def doubts(body: Body, legs: LegChains) -> Iterator[str]:
    """Masses and inertias that may be right and mostly are not, in words."""
    links, length = read_links(body.root), leg_length(body.centres, legs.chains[0])
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
        yield f"no body has a moment of inertia below zero, as {named(impossible)} would"
    wide = [
        link
        for link in links
        if link.mass > NOTABLE * total
        and np.trace(link.inertia) > 2.0 * link.mass * (GYRATION * length) ** 2
    ]
    if wide:
        yield f"the inertia of {named(wide)} is that of a larger body, in kg mm^2 perhaps"
    if massless := _massless(body):
        yield f"{name_links(massless)} has a shape and no mass"
    for left, right, masses in unlike_masses(body.model, zip(*legs.chains, strict=True), total):
        names = " and ".join(body.link(joint)[0] for joint in (left, right))
        yield f"{names} are {masses[0]:.3g} and {masses[1]:.3g} kg, though the legs are alike"


def _massless(body: Body) -> list[str]:
    """Links with a shape that have a mass of zero, or are on a body without any."""
    empty = {joint for joint, one in enumerate(body.model.inertias) if one.mass <= 0.0}
    found = []
    for link in body.root.iter("link"):
        mass, own = link.find("inertial/mass"), link.get("name", "")
        if link.find("collision") is None and link.find("visual") is None:
            continue
        frame = body.model.frames[body.model.getFrameId(own, pin.FrameType.BODY)]
        written = mass is not None and float(mass.get("value", "nan")) <= 0.0
        if written or frame.parentJoint in empty:
            found.append(own)
    return found


def check_size(body: Body, legs: LegChains) -> None:
    """Refuse what contradicts itself: nothing that is computed with it would be right.

    Raises:
        UrdfError: as `check_links`.
    """
    check_links(body.urdf, read_links(body.root), leg_length(body.centres, legs.chains[0]))


def crossed_limits(body: Body, legs: LegChains) -> list[tuple[int, int]]:
    """Joints of the left and the right leg whose limits fit each other with the wrong sign.

    The exporter of a mirrored leg has turned its axes but not its limits, or the other way round.
    """
    return [pair for pair in zip(*legs.chains, strict=True) if _crossed(body, legs, *pair)]


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
