"""Capsules around the shapes of legs."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains
from shoecal_core.drafting.soles import TOUCHING, Sole
from shoecal_core.shoe.shoe import FEET

FOOT_RADIUS = 0.25
"""Largest radius of a foot's capsule, as a part of the sole's width."""
SLIMMEST = 0.42
"""Largest radius of a thigh's or shank's capsule, as a part of the way between the left and the
right one: two legs must be able to stand side by side, and lean."""
PAIRS = (
    ("thigh", "thigh"),
    ("shank", "shank"),
    ("foot", "foot"),
    ("shank", "foot"),
    ("thigh", "shank"),
)
"""Left and right parts that might touch; different ones both ways."""


@dataclass(frozen=True)
class DraftCapsule:
    """One capsule in its link's frame [m]."""

    name: str
    link: str
    start: FloatArray
    end: FloatArray
    radius: float


def find_capsules(
    body: Body, legs: LegChains, points: Mapping[int, FloatArray], soles: Sequence[Sole]
) -> list[DraftCapsule]:
    """Thigh, shank and inner edge of each foot, as far as they have shapes.

    Args:
        points: (k, 3) corners of the shapes of each of the legs' joints, in its frame [m].
    """
    found = []
    for side, chain, sole in zip(FEET, legs.chains, soles, strict=True):
        for part, joint in _segments(body, chain).items():
            if len(points[joint]):
                link, frame = body.link(joint)
                inside = np.array([frame.actInv(point) for point in points[joint]])
                start, end, radius = around(inside)
                found.append(DraftCapsule(f"{side}_{part}", link, start, end, radius))
        found.append(_foot(body, side, chain[-1], points[chain[-1]], sole))
    return [_slim(body, legs, one, found) for one in found]


def _slim(
    body: Body, legs: LegChains, capsule: DraftCapsule, others: Sequence[DraftCapsule]
) -> DraftCapsule:
    """The same, not wider than the room next to its counterpart."""
    if capsule.name.endswith("foot"):
        return capsule
    part = capsule.name.partition("_")[2]
    twin = next((one for one in others if one.name != capsule.name and part in one.name), None)
    if twin is None:
        return capsule
    apart = abs(float((_middle(body, capsule) - _middle(body, twin)) @ legs.left))
    return replace(capsule, radius=min(capsule.radius, SLIMMEST * apart))


def _middle(body: Body, capsule: DraftCapsule) -> FloatArray:
    """(3,) in the base, in the zero pose [m]."""
    frame = body.model.frames[body.model.getFrameId(capsule.link, pin.FrameType.BODY)]
    placed = body.placements[frame.parentJoint] * frame.placement
    return np.asarray(placed.act(0.5 * (capsule.start + capsule.end)))


def pairs_of(capsules: Sequence[DraftCapsule]) -> list[tuple[str, str]]:
    """Names of the capsules that must not touch."""
    names = {capsule.name for capsule in capsules}
    pairs = [(f"left_{a}", f"right_{b}") for a, b in PAIRS]
    pairs += [(f"left_{b}", f"right_{a}") for a, b in PAIRS if a != b]
    return [(a, b) for a, b in pairs if a in names and b in names]


def around(points: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Ends and radius of a capsule around points (k, 3), along their longest extent [m]."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    axis = np.zeros(3)
    axis[int(np.argmax(np.ptp(points, axis=0)))] = 1.0
    along = (points - middle) @ axis
    off = points - middle - np.outer(along, axis)
    distance = np.linalg.norm(off, axis=1)
    radius = float(distance.max())
    cap = np.sqrt(np.maximum(radius**2 - distance**2, 0.0))
    low, high = float((along + cap).min()), float((along - cap).max())
    if low > high:
        low = high = 0.5 * (low + high)
    return middle + low * axis, middle + high * axis, radius


def _segments(body: Body, chain: Sequence[int]) -> dict[str, int]:
    """The joints that carry thigh and shank: their ends are the two longest ways of the leg."""
    ways = [
        float(np.linalg.norm(body.centres[after] - body.centres[before]))
        for before, after in itertools.pairwise(chain)
    ]
    longest = sorted(np.argsort(ways)[-2:])
    return {part: chain[place] for part, place in zip(("thigh", "shank"), longest, strict=True)}


def _foot(body: Body, side: str, joint: int, points: FloatArray, sole: Sole) -> DraftCapsule:
    """Along the inner edge: two feet in place touch there first, shanks reach there first."""
    link, frame = body.link(joint)
    inside = np.array([(frame * sole.placement).actInv(point) for point in points])
    width = float(np.ptp(sole.outline[:, 1]))
    thickness = float(inside[:, 2].max()) if len(inside) else 0.0
    if thickness < TOUCHING:
        thickness = sole.height  # no shape says more than where the sole is
    radius = min(0.5 * thickness, FOOT_RADIUS * width)
    back, front = float(sole.outline[:, 0].min()), float(sole.outline[:, 0].max())
    inner = (
        sole.outline[:, 1].min() + radius if side == "left" else sole.outline[:, 1].max() - radius
    )
    inset = min(radius + 0.1 * (front - back), 0.4 * (front - back))
    ends = [sole.placement.act(np.array([x, inner, radius])) for x in (back + inset, front - inset)]
    return DraftCapsule(f"{side}_foot", link, ends[0], ends[1], radius)
