"""Which joints of a URDF are legs: two like chains that reach lowest."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.robot.joint_centres import own_joints
from shoecal_core.robot.leg_links import unlike_links
from shoecal_core.robot.urdf import UrdfError

LEAST_MOTORS = 8
"""Six hold two feet in place, two more move the body."""
LIKE = 0.02
"""Part of a chain's length by which mirrored joints may be off."""
ALMOST = 0.3
"""Likewise, of two legs of which one has a wrong link."""
LEVEL = 0.1
"""Part of a leg's length: chains that end higher by less than this reach as low."""
ARM = re.compile(r"arm|hand|wrist|elbow|shoulder|finger|gripper", re.IGNORECASE)
UP = np.array([0.0, 0.0, 1.0])
"""The base's z axis, by REP-103."""


@dataclass(frozen=True)
class LegChains:
    """Two legs in the zero pose.

    Attributes:
        chains: left, right: joints of the model from the hip to the foot.
        left: (3,) unit vector from the right leg to the left, in the base.
        forward: (3,) where the robot looks, in the base.
        named: the joints' names say which one is the left leg.
    """

    chains: tuple[tuple[int, ...], tuple[int, ...]]
    left: FloatArray
    forward: FloatArray
    named: bool


def find_legs(body: Body) -> LegChains:
    """The two legs of a humanoid whose base's z axis points up.

    Raises:
        UrdfError: for a robot without two feet, or with more.
    """
    ends = _ends(body)
    pairs = _pairs(body, ends, LIKE)
    _check_alike(body, pairs, _pairs(body, ends, ALMOST))
    if not pairs:
        _check_fixed(body)
        listed = ", ".join(str(body.model.names[chain[-1]]) for chain in ends)
        raise UrdfError(
            body.urdf,
            "has no feet: no two chains of joints are each other's mirror image (chains end at: "
            f"{listed}); shoecal needs a humanoid on two legs",
        )
    chains = min(pairs, key=lambda pair: _height(body, pair[0]))
    _check_feet(body, chains, ends)
    named = _left_first([[str(body.model.names[joint]) for joint in chain] for chain in chains])
    one, other = chains if named is not False else (chains[1], chains[0])
    left = _apart(body, one, other)
    if named is None and np.cross(left, UP)[0] < 0.0:
        one, other, left = other, one, -left
    left = _snapped(left)
    return LegChains((one, other), left, np.cross(left, UP), named is not None)


def _ends(body: Body) -> list[tuple[int, ...]]:
    """Chains of joints from the base to every last one."""
    model = body.model
    parents = {int(model.parents[joint]) for joint in own_joints(model)}
    return [
        tuple(joint for joint in model.supports[end] if joint in own_joints(model))
        for end in own_joints(model)
        if end not in parents
    ]


def _pairs(
    body: Body, ends: Sequence[tuple[int, ...]], like: float
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Chains that are each other's mirror image to within this part of their length."""
    return [
        pair
        for one, other in itertools.combinations(ends, 2)
        if (pair := _mirrored(body, one, other, like)) is not None
    ]


def _check_alike(
    body: Body,
    pairs: Sequence[tuple[tuple[int, ...], tuple[int, ...]]],
    almost: Sequence[tuple[tuple[int, ...], tuple[int, ...]]],
) -> None:
    """Refuse legs that are almost alike: two chains that reach lower than all that are alike."""
    lowest = min((_height(body, pair[0]) for pair in pairs), default=np.inf)
    legs = [
        pair
        for pair in almost
        if len(pair[0]) * 2 >= LEAST_MOTORS
        and max(_height(body, chain) for chain in pair) < lowest
        and not any(ARM.search(str(body.model.names[joint])) for joint in pair[0])
    ]
    if not legs:
        return
    best = min(legs, key=lambda pair: _height(body, pair[0]))
    unlike = unlike_links(body.model, body.placements, best)
    if unlike is not None and unlike.off > LIKE * unlike.length:
        raise UrdfError(body.urdf, unlike.text, field="joint origins")


def _mirrored(
    body: Body, one: tuple[int, ...], other: tuple[int, ...], like: float
) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """Both chains after their fork, where one is the mirror image of the other."""
    shared = sum(a == b for a, b in zip(one, other, strict=False))
    one, other = one[shared:], other[shared:]
    if len(one) != len(other) or len(one) < 2:
        return None
    a, b = (np.array([body.centres[joint] for joint in chain]) for chain in (one, other))
    length = float(np.linalg.norm(np.diff(a, axis=0), axis=1).sum())
    across = (a - b).sum(axis=0)
    if length < 1e-6 or np.linalg.norm(across) < 1e-6:
        return None
    across /= np.linalg.norm(across)
    off = (a - b) - np.outer((a - b) @ across, across)
    middle = 0.5 * (a + b) @ across
    alike = np.abs(off).max() < like * length and np.ptp(middle) < like * length
    return (one, other) if alike and abs(across @ UP) < 0.1 else None


def _height(body: Body, chain: Sequence[int]) -> float:
    return float(body.centres[chain[-1]] @ UP)


def _apart(body: Body, one: Sequence[int], other: Sequence[int]) -> FloatArray:
    """Unit vector from the other chain to the one."""
    across = np.sum(
        [body.centres[a] - body.centres[b] for a, b in zip(one, other, strict=True)], axis=0
    )
    return np.asarray(across / np.linalg.norm(across))


def _snapped(direction: FloatArray) -> FloatArray:
    """The base's own axis where that is all but meant."""
    axis = np.zeros(3)
    largest = int(np.argmax(np.abs(direction)))
    axis[largest] = np.sign(direction[largest])
    return axis if direction @ axis > np.cos(np.radians(2.0)) else direction


def _check_feet(
    body: Body, chains: tuple[tuple[int, ...], tuple[int, ...]], ends: Sequence[tuple[int, ...]]
) -> None:
    names = [str(body.model.names[joint]) for joint in chains[0]]
    length = _height(body, chains[0][:1]) - _height(body, chains[0])
    if length <= 0.0 or any(ARM.search(name) for name in names):
        _check_fixed(body)
        raise UrdfError(
            body.urdf,
            f"has no feet: the lowest two like chains ({', '.join(names)} and its mirror image) "
            "are arms, or do not reach down from the base; give the URDF of the whole robot, with "
            "its base's z axis upward",
        )
    lowest = _height(body, chains[0])
    low = [
        str(body.model.names[chain[-1]])
        for chain in ends
        if _height(body, chain) < lowest + LEVEL * length
        and chains[0][0] not in chain
        and chains[1][0] not in chain
        and not any(ARM.search(str(body.model.names[joint])) for joint in chain)
    ]
    if low:
        raise UrdfError(
            body.urdf,
            f"has more than two feet (also {', '.join(low)}); shoecal calibrates humanoids on two",
        )
    motors = [
        joint for chain in chains for joint in chain if body.model.names[joint] not in body.mimics
    ]
    if len(motors) < LEAST_MOTORS:
        raise UrdfError(
            body.urdf,
            f"its legs have {len(motors)} motors ({', '.join(names)} and its mirror image); two "
            f"feet that stay in place and a body that moves need {LEAST_MOTORS} or more",
        )


def _check_fixed(body: Body) -> None:
    """Refuse a joint that is fixed in one leg and moves in the other, by its name."""
    moving = {str(name) for name in body.model.names}
    fixed = [str(one.name) for one in body.model.frames if one.type == pin.FrameType.FIXED_JOINT]
    for name in fixed:
        like = sorted(_other_side(name) & moving)
        if like and not ARM.search(name):
            raise UrdfError(
                body.urdf,
                f"is fixed, but {like[0]} moves, so no two legs are alike; give it type revolute "
                "and its limits, or fix both",
                field=f"joint {name}",
            )


def _other_side(name: str) -> set[str]:
    """Names that a joint's like on the other side may have."""
    words = [("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R")]
    return {
        name[: found.start()] + new + name[found.end() :]
        for pair in words
        for old, new in (pair, pair[::-1])
        for found in re.finditer(old, name)
    }


def _left_first(names: Sequence[Sequence[str]]) -> bool | None:
    """Whether the first of two chains is the left one by its joints' names; None: not clear."""
    for one, other in zip(*names, strict=True):
        for a, b in zip(one.lower(), other.lower(), strict=False):
            if a != b:
                if {a, b} == {"l", "r"}:
                    return bool(a == "l")
                break
    return None
