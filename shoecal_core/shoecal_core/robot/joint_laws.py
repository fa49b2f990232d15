"""What joint angles may be but off by a constant: turned signs, exchanged joints, another scale."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations

import numpy as np
from scipy.optimize import minimize_scalar

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.level_soles import CLOSED_M, CLOSED_RAD, Postures, off_level
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.urdf import ROOT_JOINTS

BETTER = 0.5
"""Of the misfit as recorded, what a correction may leave."""
AS_GOOD, ALIKE = 1.5, 0.05
"""Joints whose correction leaves so many times the least misfit, and this, explain the soles as
well."""
MOST_NAMED = 3
ALL_SHARE = 0.8
"""Of samples that a law has to close, and a zero where the soles are level as recorded, and only
wander: feet that step do so, too."""
REACH_RAD, FINE_RAD = 1.4, 0.02
"""The true angle of an encoder that fails is looked for so far off, in such steps."""
LEAST_RAD, CONSTANT_RAD = 2.0 * CLOSED_RAD, 1e-6
"""An encoder that fails changes by less than the last while others change by the first."""
FACTORS = 2.0 ** (np.arange(-8.0, 9.0) / 4.0)
"""Scales that are looked for: gears and belts between encoder and joint turn up to four to one; and
servos of one series give the same numbers for ranges that are half as wide again."""
UNITS = (float(np.degrees(1.0)), float(np.radians(1.0)))
"""Scales of an angle that is converted to radians twice, or not at all."""
LEAST_FACTOR = 0.1
"""Scales that are nearer to one are errors of a calibration, which the fit finds."""
ROUND = tuple(sorted({a / b for a in range(1, 5) for b in range(1, 5) if a != b}))
NEAR_ROUND = 0.04
"""A scale as near to a ratio of small numbers is that one: play and sag of joints shift it."""


class Law(Enum):
    """What one joint, or two, may be but a constant error: in words, and what to do."""

    SIGN = ("a joint's sign is turned (best fit: {} with the other sign)", "correct the sign")
    SIGNS = (
        "one joint has its sign turned in both legs (best fit: {} with the other sign)",
        "correct both signs",
    )
    EXCHANGED = (
        "two joints are exchanged (best fit: {} at each other's place)",
        "exchange their names or cables",
    )
    LEGS = (
        "the left and the right leg are exchanged (best fit: {} at each other's place)",
        "exchange their names or the legs' cables",
    )
    SCALE = (
        "a joint's angle has another scale (best fit: {})",
        "correct its gear ratio or its unit",
    )
    FROZEN = (
        "an encoder fails (best fit: {} moves, and its recorded angle does not)",
        "see to its encoder",
    )


@dataclass(frozen=True)
class Explained:
    """What closes the loop of both legs.

    Attributes:
        law: None where none does.
        names: joints that do so by that law, the best first; of two, joined by `and`.
        factors: by which their angles are to be multiplied, where that is the law.
    """

    law: Law | None = None
    names: tuple[str, ...] = ()
    factors: tuple[float, ...] = ()


@dataclass(frozen=True)
class _Candidate:
    """A law, by which joints, and the postures that then were."""

    law: Law
    name: str
    postures: Postures
    factor: float = 1.0

    @property
    def misfit(self) -> float:
        """What it leaves; a scale, which is free, is as good as a law without a size only where it
        leaves clearly less.
        """
        return self.postures.misfit + (ALIKE if self.law is Law.SCALE else 0.0)


def by_law(postures: Postures, constant: Sequence[int], least: float) -> Explained:
    """The law that closes the loop and leaves less than a misfit, and by which joints.

    A sign that only makes up for a constant error is none: angles that hardly change have either.

    Args:
        postures: as recorded.
        constant: joints whose angles never change while others do.
        least: misfit that a constant error of one joint leaves.
    """
    most = BETTER * min(least, postures.misfit)
    found = [
        one
        for one in _candidates(postures, constant)
        if one.postures.misfit < most and one.postures.closed(ALL_SHARE)
    ]
    if not found:
        return Explained()
    # Where no hip rolls, exchanged legs look like turned signs of both yaws: cables are likelier.
    found.sort(key=lambda one: (round(one.misfit, 3), one.law is not Law.LEGS))
    best = found[0]
    near = {
        one.name: one.factor
        for one in reversed(found)
        if one.law is best.law and one.misfit <= AS_GOOD * best.misfit + ALIKE
    }
    names = tuple(reversed(near))[:MOST_NAMED]
    factors = tuple(near[name] for name in names) if best.law is Law.SCALE else ()
    return Explained(best.law, names, factors)


def constant_joints(robot: Robot, angles: FloatArray) -> list[int]:
    """Joints between the feet whose angles (T, m) never change while others do."""
    between = list(robot.between_feet)
    moved = np.ptp(angles[:, between], axis=0)
    if moved.max(initial=0.0) < LEAST_RAD:
        return []
    return [joint for joint, own in zip(between, moved, strict=True) if own < CONSTANT_RAD]


def motors(robot: Robot) -> list[list[tuple[int, float]]]:
    """What one error may turn on the way from one sole to the other: each motor's joints, by index,
    with their ratios; and joints on one motor also alone, as both may be measured.
    """
    follows = {one.joint: one.leader for one in robot.shared}
    leaders = sorted({follows.get(joint, joint) for joint in robot.between_feet})
    together = [
        [(leader, 1.0), *((one.joint, one.ratio) for one in robot.shared if one.leader == leader)]
        for leader in leaders
    ]
    shared = {joint for group in together if len(group) > 1 for joint, _ in group}
    return together + [[(joint, 1.0)] for joint in robot.between_feet if joint in shared]


def _candidates(postures: Postures, constant: Sequence[int]) -> Iterator[_Candidate]:
    """Every law that may be."""
    robot = postures.kinematics.robot
    names = robot.joint_names
    for group in motors(robot):
        joints = [joint for joint, _ in group]
        yield _Candidate(Law.SIGN, names[joints[0]], _times(postures, joints, -1.0))
        factor = _factor(postures, joints)
        if abs(np.log(factor)) > LEAST_FACTOR:
            scaled = _times(postures, joints, factor)
            yield _Candidate(Law.SCALE, names[joints[0]], scaled, factor)
    for one, other in _homologous(robot):
        pair = f"{names[one]} and {names[other]}"
        yield _Candidate(Law.SIGNS, pair, _times(postures, [one, other], -1.0))
    for one, other in combinations(robot.between_feet, 2):
        exchanged = postures.angles.copy()
        exchanged[:, [one, other]] = postures.angles[:, [other, one]]
        pair = f"{names[one]} and {names[other]}"
        yield _Candidate(Law.EXCHANGED, pair, postures.changed(exchanged))
    left, right = leg_joints(robot)
    if len(left) == len(right):
        exchanged = postures.angles.copy()
        exchanged[:, left + right] = postures.angles[:, right + left]
        yield _Candidate(Law.LEGS, "the joints of both legs", postures.changed(exchanged))
    for joint in constant:
        yield _Candidate(Law.FROZEN, names[joint], _moved(postures, joint))


def _homologous(robot: Robot) -> list[tuple[int, int]]:
    """Joints at the same place in both legs, by index, that turn by motors of their own."""
    left, right = leg_joints(robot)
    on_shared = {joint for one in robot.shared for joint in (one.joint, one.leader)}
    if len(left) != len(right):
        return []
    return [pair for pair in zip(left, right, strict=True) if on_shared.isdisjoint(pair)]


def leg_joints(robot: Robot) -> tuple[list[int], list[int]]:
    """Joints of the left and the right leg, by index, from the hip to the foot."""
    left, right = ([int(joint) - ROOT_JOINTS for joint in leg] for leg in robot.leg_chains)
    return left, right


def _times(postures: Postures, joints: Sequence[int], factor: float) -> Postures:
    angles = postures.angles.copy()
    angles[:, joints] *= factor
    return postures.changed(angles)


def _factor(postures: Postures, joints: Sequence[int]) -> float:
    """The scale of joints' angles that leaves the least misfit."""

    def misfit(exponent: float) -> float:
        return _times(postures, joints, float(np.exp(exponent))).misfit

    tried = np.log([*FACTORS, *UNITS])
    start = float(tried[np.argmin([misfit(float(one)) for one in tried])])
    if start == 0.0:
        return 1.0
    step = 0.5 * float(np.log(FACTORS[1] / FACTORS[0]))
    bounds = (start - step, start + step)
    found = float(np.exp(minimize_scalar(misfit, bounds=bounds, method="bounded").x))
    near = min((*ROUND, *UNITS), key=lambda one: abs(np.log(found / one)))
    return near if abs(np.log(found / near)) < NEAR_ROUND else found


def _moved(postures: Postures, joint: int) -> Postures:
    """With angles of one joint that bring the soles nearest to level, each instant."""
    sizes = np.arange(-REACH_RAD, REACH_RAD + 0.5 * FINE_RAD, FINE_RAD)
    angles = postures.angles
    several = np.repeat(angles[:, None], len(sizes), axis=1)
    several[:, :, joint] += sizes
    height, tilt = off_level(postures.kinematics.states(several.reshape(-1, angles.shape[1])))
    off = (height / CLOSED_M) ** 2 + (tilt / CLOSED_RAD) ** 2
    moved = angles.copy()
    moved[:, joint] += sizes[off.reshape(len(angles), -1).argmin(axis=1)]
    return postures.changed(moved)
