"""Links of other lengths than in the URDF, and angles of another scale: by feet that stay in place.

While both feet stand, one sole does not move against the other. A link of another length makes it
seem to, wherever knees bend; an encoder with other counts per turn does, wherever its joint moves.
Errors of zeros do so in another way: what leaves least of that motion, each with one size, is the
likeliest. Shins that are shorter and thighs that are longer move the soles alike: then both are
named.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.urdf import ROOT_JOINTS
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.verdict import Finding

SAMPLES = 100
"""Of each run, evenly over it; a run's soles have one place in it."""
UNIT_M, UNIT_RAD = 0.001, 0.004
"""Motion and turn of a sole that count alike."""
STEP_M, STEP_RAD, STEP_SHARE = 0.002, 0.005, 0.01
"""Of derivatives."""
LEAST_M = 0.003
"""Smaller errors of lengths are as built."""
MOST_SHARE = 0.3
"""Of a link's length, that no robot of that kind is off by: legs that move alike show nothing."""
LEAST_SHARE = 0.02
"""Of an angle; encoders and gears are counted out, and what is left harms less than their play."""
LEFT = 0.4
"""Of the sum of squares, what a length or scale leaves at most: shins 12 mm off leave 0.09; sound
sessions keep 0.94 and more."""
BETTER = 0.5
"""Of what the best zero leaves, what a length leaves at most; the same for a scale, of lengths
too."""
AS_GOOD = 1.5
"""What leaves so many times the least explains the soles as well."""
LONG = 0.2
"""Of a leg's length, from which it is a link that is measured; others are offsets of axes."""


@dataclass(frozen=True)
class OtherLength:
    """Links that are longer or shorter than in the URDF.

    Attributes:
        links: their names.
        joints: at their far ends, whose origins say how long they are.
        longer: than in the URDF, negative where shorter [m].
    """

    links: tuple[str, ...]
    joints: tuple[str, ...]
    longer: float


@dataclass(frozen=True)
class OtherScale:
    """A joint that turns by more or less than its angles say.

    Attributes:
        joint: its name.
        more: turned beyond what is recorded, as a share of it; negative where less.
    """

    joint: str
    more: float


@dataclass(frozen=True)
class _Standing:
    """Samples of T instants at which both feet stand: joint angles (T, m), run of each (T,)."""

    angles: FloatArray
    run: FloatArray

    def of_joint(self, joint: int) -> FloatArray:
        """(T, m) the angles of one joint alone."""
        return np.where(np.arange(self.angles.shape[1]) == joint, self.angles, 0.0)

    def motion(self, kinematics: Kinematics, angles: FloatArray | None = None) -> FloatArray:
        """(3T,) how far the right sole is off its place in the run, in units."""
        states = kinematics.states(self.angles if angles is None else angles)
        place = np.column_stack((states.translation[:, :2], np.unwrap(states.yaw)))
        for run in np.unique(self.run):
            place[self.run == run] -= place[self.run == run].mean(axis=0)
        return np.asarray((place / (UNIT_M, UNIT_M, UNIT_RAD)).ravel())


def leg_errors(
    kinematics: Kinematics, aligned: Mapping[int, Aligned], standing: Mapping[int, BoolArray]
) -> list[OtherLength] | list[OtherScale]:
    """What explains far better than any zero does how soles move that should not.

    Args:
        kinematics: of the robot as its files say.
        aligned: runs in double support, by number.
        standing: of each of them (T,) samples at which both feet stand in their places.

    Returns:
        Alternatives, the best first; none where all is right, or zeros explain it as well.
    """
    chosen = _chosen(aligned, standing)
    if chosen is None:
        return []
    robot, now = kinematics.robot, chosen.motion(kinematics)

    def turned(turn: FloatArray, step: float) -> tuple[float, float]:
        """With so much more of angles that are off by (m,) or (T, m)."""
        return _fitted(now, (chosen.motion(kinematics, chosen.angles + step * turn) - now) / step)

    zero = min(turned(one, STEP_RAD)[0] for one in _zeros(robot))
    lengths = list(_lengths(robot, chosen, now))
    scales = [
        (left, size, joint)
        for joint in robot.between_feet
        for left, size in [turned(chosen.of_joint(joint), STEP_SHARE)]
        if abs(size) > LEAST_SHARE
    ]
    least_length, least_scale = (
        min((one[0] for one in found), default=np.inf) for found in (lengths, scales)
    )
    if least_scale < min(LEFT, BETTER * min(zero, least_length)):
        return [
            OtherScale(robot.joint_names[joint], size)
            for left, size, joint in sorted(scales)
            if left < AS_GOOD * least_scale
        ]
    if least_length > min(LEFT, BETTER * zero):
        return []
    return [
        OtherLength(
            tuple(first_link(robot.model, robot.model.parents[joint]).name for joint in joints),
            tuple(robot.model.names[joint] for joint in joints),
            size,
        )
        for left, size, joints in sorted(lengths)
        if left < AS_GOOD * least_length
    ]


def _lengths(
    robot: Robot, chosen: _Standing, now: FloatArray
) -> Iterator[tuple[float, float, tuple[int, ...]]]:
    """What each link's length leaves of the motion (3T,), its size [m], and its joints."""
    for joints in _links(robot):
        slope = (chosen.motion(Kinematics(_longer(robot, joints, STEP_M))) - now) / STEP_M
        left, size = _fitted(now, slope)
        if LEAST_M < abs(size) < MOST_SHARE * min(_length(robot, joint) for joint in joints):
            yield left, size, joints


def _chosen(aligned: Mapping[int, Aligned], standing: Mapping[int, BoolArray]) -> _Standing | None:
    angles, runs = list[FloatArray](), list[FloatArray]()
    for run, there in standing.items():
        at = np.flatnonzero(there)
        if len(at):
            at = at[np.unique(np.linspace(0, len(at) - 1, SAMPLES).astype(np.int64))]
            angles.append(aligned[run].joint_angles[at])
            runs.append(np.full(len(at), float(run)))
    return _Standing(np.concatenate(angles), np.concatenate(runs)) if angles else None


def _fitted(now: FloatArray, slope: FloatArray) -> tuple[float, float]:
    """Of motion (3T,), the part of its sum of squares that is left by a size that adds so much of
    `slope` (3T,), and that size.
    """
    square = float(slope @ slope)
    size = -float(slope @ now) / square if square > 0.0 else 0.0
    left = now + size * slope
    return float(left @ left) / max(float(now @ now), 1e-12), size


def _links(robot: Robot) -> Iterator[tuple[int, ...]]:
    """Joints at the far end of each long link, of both legs and of one."""
    legs = [_long(robot, leg) for leg in robot.leg_chains]
    if len(legs[0]) == len(legs[1]):
        yield from zip(*legs, strict=True)
    for leg in legs:
        yield from ((joint,) for joint in leg)


def _long(robot: Robot, leg: Sequence[int]) -> list[int]:
    """Of a leg's joints those at the far end of a long link."""
    below = leg[1:]
    whole = sum(_length(robot, one) for one in below)
    return [one for one in below if _length(robot, one) > LONG * whole]


def _length(robot: Robot, joint: int) -> float:
    """From the joint above it [m]."""
    return float(np.linalg.norm(robot.model.jointPlacements[joint].translation))


def _longer(robot: Robot, joints: Sequence[int], size: float) -> Robot:
    """With links that are longer along the way to these joints [m]."""
    model = robot.model.copy()
    for joint in joints:
        placement = robot.model.jointPlacements[joint]
        along = placement.translation
        model.jointPlacements[joint] = pin.SE3(
            placement.rotation, along * (1.0 + size / float(np.linalg.norm(along)))
        )
    return replace(robot, model=model)


def _zeros(robot: Robot) -> Iterator[FloatArray]:
    """(m,) what zeros may add to the joint angles: of one joint, of those on one motor, and of the
    same one of both legs, either way round.
    """
    count = len(robot.joint_names)
    for joint in robot.between_feet:
        yield np.eye(count)[joint]
    for motor in robot.shared:
        yield np.eye(count)[motor.leader] + motor.ratio * np.eye(count)[motor.joint]
    left, right = robot.leg_chains
    if len(left) == len(right):
        for (one, other), sign in product(zip(left, right, strict=True), (1.0, -1.0)):
            yield np.eye(count)[one - ROOT_JOINTS] + sign * np.eye(count)[other - ROOT_JOINTS]


def describe_leg_errors(found: Sequence[OtherLength] | Sequence[OtherScale]) -> list[Finding]:
    """Links to measure, or encoders to look at."""
    if not found:
        return []
    scales = [one for one in found if isinstance(one, OtherScale)]
    if scales:
        listed = " or ".join(
            f"{one.joint} turned {abs(one.more):.1%} {'more' if one.more > 0.0 else 'less'}"
            for one in scales
        )
        return [
            Finding(
                "WARN",
                f"by the joint angles the soles move while both stand, as if {listed} than "
                "recorded: check its gear ratio and its encoder's counts per turn in the driver, "
                "then record again",
            )
        ]
    found = [one for one in found if isinstance(one, OtherLength)]
    sizes = ", or ".join(
        f"{' and '.join(one.links)} {1e3 * abs(one.longer):.0f} mm "
        f"{'longer' if one.longer > 0.0 else 'shorter'}"
        for one in found
    )
    joints = "; or of ".join(" and ".join(one.joints) for one in found)
    return [
        Finding(
            "WARN",
            f"by the joint angles the soles move while both stand, as if links were of other "
            f"lengths than in the URDF ({sizes}): measure them, correct the joint origins of "
            f"{joints} in the URDF, then calibrate again",
        )
    ]
