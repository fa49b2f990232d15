"""Are links of the legs longer or shorter than the URDF says? By feet that stay in place.

While both feet stand, one sole does not move against the other. A link of another length makes it
seem to, wherever knees bend. Errors of zeros do so in another way: what leaves least of that
motion, each with one size, is the likeliest. Shins that are shorter and thighs that are longer move
the soles alike: then both are named.
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
STEP_M, STEP_RAD = 0.002, 0.005
"""Of derivatives."""
LEAST_M = 0.003
"""Smaller errors of lengths are as built."""
MOST_SHARE = 0.3
"""Of a link's length, that no robot of that kind is off by: legs that move alike show nothing."""
LEFT = 0.4
"""Of the sum of squares, what a length leaves at most: shins 12 mm off leave 0.09; sound sessions
keep 0.94 and more."""
THAN_ZEROS = 0.5
"""Of what the best zero leaves, what a length leaves at most."""
AS_GOOD = 1.5
"""Lengths that leave so many times the least explain the soles as well."""
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
class _Standing:
    """Samples of T instants at which both feet stand: joint angles (T, m), run of each (T,)."""

    angles: FloatArray
    run: FloatArray

    def motion(self, kinematics: Kinematics, angles: FloatArray | None = None) -> FloatArray:
        """(3T,) how far the right sole is off its place in the run, in units."""
        states = kinematics.states(self.angles if angles is None else angles)
        place = np.column_stack((states.translation[:, :2], np.unwrap(states.yaw)))
        for run in np.unique(self.run):
            place[self.run == run] -= place[self.run == run].mean(axis=0)
        return np.asarray((place / (UNIT_M, UNIT_M, UNIT_RAD)).ravel())


def other_lengths(
    kinematics: Kinematics, aligned: Mapping[int, Aligned], standing: Mapping[int, BoolArray]
) -> list[OtherLength]:
    """Lengths that explain, far better than any zero does, how soles move that should not.

    Args:
        kinematics: of the robot as its files say.
        aligned: runs in double support, by number.
        standing: of each of them (T,) samples at which both feet stand in their places.

    Returns:
        Alternatives, the best first; none where lengths are right, or zeros explain it as well.
    """
    chosen = _chosen(aligned, standing)
    if chosen is None:
        return []
    robot, now = kinematics.robot, chosen.motion(kinematics)
    lengths = []
    for joints in _links(robot):
        slope = (chosen.motion(Kinematics(_longer(robot, joints, STEP_M))) - now) / STEP_M
        left, size = _fitted(now, slope)
        if LEAST_M < abs(size) < MOST_SHARE * min(_length(robot, joint) for joint in joints):
            lengths.append((left, size, joints))
    if not lengths:
        return []
    least = min(left for left, _, _ in lengths)
    if least > LEFT or least > THAN_ZEROS * min(
        _fitted(now, (chosen.motion(kinematics, chosen.angles + STEP_RAD * turn) - now))[0]
        for turn in _zeros(robot)
    ):
        return []
    return [
        OtherLength(
            tuple(first_link(robot.model, robot.model.parents[joint]).name for joint in joints),
            tuple(robot.model.names[joint] for joint in joints),
            size,
        )
        for left, size, joints in sorted(lengths)
        if left < AS_GOOD * least
    ]


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


def _legs(robot: Robot) -> list[list[int]]:
    """Joints of the model from hip to sole, of each leg."""
    left, right = ([int(one) for one in robot.model.supports[foot.joint]] for foot in robot.feet)
    shared = {*left} & {*right}
    return [[one for one in leg if one not in shared] for leg in (left, right)]


def _links(robot: Robot) -> Iterator[tuple[int, ...]]:
    """Joints at the far end of each long link, of both legs and of one."""
    legs = [_long(robot, leg) for leg in _legs(robot)]
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
    left, right = _legs(robot)
    if len(left) == len(right):
        for (one, other), sign in product(zip(left, right, strict=True), (1.0, -1.0)):
            yield np.eye(count)[one - ROOT_JOINTS] + sign * np.eye(count)[other - ROOT_JOINTS]


def describe_lengths(found: Sequence[OtherLength]) -> list[Finding]:
    """Links to measure."""
    if not found:
        return []
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
