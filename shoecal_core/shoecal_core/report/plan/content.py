"""What the report on planned motions is made from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.planning.checking.body_track import BodyTrack, track
from shoecal_core.planning.checking.findings import Report
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET

SAME = 1e-3
"""m; places nearer to each other than this are drawn as one."""
BOTH = "both"
STABILITY = "distance of the CoP from the edge of the sensing polygon"
"""Name of a constraint of the check."""


@dataclass(frozen=True)
class Target:
    """A place that the CoP pursued.

    Attributes:
        number: in the order of pursuit, from 1.
        place: (2,) in the world [m].
        nearest: the planner's distance to it, of the torso's lean and height too where these were
            pursued; infinite where it was never pursued [m].
        cop_distance: of the CoP alone [m].
        reached: it came as near as it should.
        sample: of the motion at which the CoP was nearest; -1 where never pursued.
    """

    number: int
    place: FloatArray
    nearest: float
    cop_distance: float
    reached: bool
    sample: int

    @property
    def pursued(self) -> bool:
        """Whether the planner came to it at all."""
        return bool(np.isfinite(self.nearest))

    def off(self, radius: float) -> str:
        """What is missing: the distance, or what else.

        Args:
            radius: within which a landmark is reached [m].
        """
        if not self.pursued:
            return "never pursued"
        if self.cop_distance < radius:
            return "lean or height off"
        return f"{1e3 * self.nearest:.1f} mm off"


@dataclass(frozen=True)
class TargetMark:
    """Targets at one place, as figures show them.

    Attributes:
        numbers: for example `1, 3–5`.
        missing: of the worst that was not reached; empty where all were.
        place: (2,) [m].
    """

    numbers: str
    missing: str
    place: FloatArray

    @property
    def label(self) -> str:
        """Its numbers and what is missing."""
        return f"{self.numbers}: {self.missing}" if self.missing else self.numbers


def marks_of(targets: Sequence[Target], radius: float) -> tuple[TargetMark, ...]:
    """Each place once, in the order of first pursuit.

    Args:
        targets: of a motion.
        radius: within which a landmark is reached [m].
    """
    groups: list[list[Target]] = []
    for target in targets:
        for group in groups:
            if np.linalg.norm(group[0].place - target.place) < SAME:
                group.append(target)
                break
        else:
            groups.append([target])
    marks = []
    for group in groups:
        missed = [one for one in group if not one.reached]
        worst = max(missed, key=lambda one: one.nearest, default=None)
        marks.append(
            TargetMark(
                numbers=", ".join(_runs([one.number for one in group])),
                missing="" if worst is None else worst.off(radius),
                place=group[0].place,
            )
        )
    return tuple(marks)


def _runs(numbers: Sequence[int]) -> Iterator[str]:
    """Neighbouring numbers as `3–5`."""
    begin = 0
    for index in range(1, len(numbers) + 1):
        if index == len(numbers) or numbers[index] != numbers[index - 1] + 1:
            first, last = numbers[begin], numbers[index - 1]
            yield str(first) if first == last else f"{first}–{last}"
            begin = index


@dataclass(frozen=True)
class Stand:
    """A while in which the same feet carry the robot.

    Attributes:
        feet: `both`, `left` or `right`.
        begin, end: samples of the motion, the end not included.
    """

    feet: str
    begin: int
    end: int


@dataclass(frozen=True)
class PlannedMotion:
    """One motion as it was planned and checked.

    The world is the left sole's frame at the start of the motion, z up.

    Attributes:
        label: its file's name without the ending.
        robot: that shall move so.
        motion: what was planned.
        report: of the independent check.
        settings: of planning.
    """

    label: str
    robot: Robot
    motion: Motion
    report: Report
    settings: PlannerSettings

    @cached_property
    def body(self) -> BodyTrack:
        """What the body does, in the left sole's frame."""
        shares = np.zeros((len(self.motion.time), 2))
        for stand in self.stands:
            shares[stand.begin : stand.end] = SupportPhase(stand.feet).share
        return track(self.robot, self.motion.positions, shares)

    @cached_property
    def stands(self) -> tuple[Stand, ...]:
        """Which feet carry, one after another, over the whole motion."""
        phases, count = self.motion.phases, len(self.motion.time)
        begins = np.searchsorted(self.motion.time, [phase.begin for phase in phases]).tolist()
        found: list[Stand] = []
        for phase, begin, end in zip(phases, begins, [*begins[1:], count], strict=True):
            same = bool(found) and found[-1].feet == phase.support_phase.value
            first = found.pop().begin if same else begin
            found.append(Stand(phase.support_phase.value, first, end))
        return tuple(found)

    @cached_property
    def stance(self) -> IntArray:
        """(T,) index of a foot that stands at each sample; of two, the left."""
        feet = np.zeros(len(self.motion.time), dtype=np.int64)
        for stand in self.stands:
            feet[stand.begin : stand.end] = int(stand.feet == FEET[1])
        return feet

    @cached_property
    def soles(self) -> tuple[FloatArray, FloatArray]:
        """(T, 2, 3, 3) and (T, 2, 3): poses of left and right sole in the world [m].

        The foot that carries stays where it stands; the other one follows from the joints.
        """
        body, count = self.body, len(self.motion.time)
        rotation, place = np.zeros((count, 2, 3, 3)), np.zeros((count, 2, 3))
        held, at = [np.eye(3), body.right_rotation[0]], [np.zeros(3), body.right_translation[0]]
        for index, stance in enumerate(self.stance):
            between, way = body.right_rotation[index], body.right_translation[index]
            if stance == 0:
                held[1], at[1] = held[0] @ between, at[0] + held[0] @ way
            else:
                held[0] = held[1] @ between.T
                at[0] = at[1] - held[0] @ way
            rotation[index], place[index] = held, at
        return rotation, place

    @cached_property
    def com(self) -> FloatArray:
        """(T, 3) in the world [m]."""
        rotation, place = self.soles
        com: FloatArray = np.einsum("tij,tj->ti", rotation[:, 0], self.body.com) + place[:, 0]
        return com

    @property
    def cop(self) -> FloatArray:
        """(T, 2) the CoM's ground projection in the world [m]."""
        return self.com[:, :2]

    @cached_property
    def torque_share(self) -> FloatArray:
        """(T, k) holding torques of the leg motors over their limits, with sign."""
        share: FloatArray = self.body.torques / self.robot.effort_limit[self.robot.legs]
        return share

    @property
    def peak_torque(self) -> tuple[float, str]:
        """The highest share of a motor's limit, and its joint."""
        peaks = np.abs(self.torque_share).max(axis=0)
        column = int(np.argmax(peaks))
        return float(peaks[column]), self.robot.leg_names[column]

    @property
    def least_room(self) -> float:
        """The least distance from the CoP to the edge of where it may be [m]."""
        return self.report.of(STABILITY).value

    @cached_property
    def targets(self) -> tuple[Target, ...]:
        """All places that the CoP should pursue."""
        path, found, begin = self.motion.path, [], 0
        ends = self._switches()
        for index, (local, nearest) in enumerate(zip(path.targets, path.nearest, strict=True)):
            end = ends[index] if index < len(ends) else len(self.cop) - 1
            place = self._in_world(local, end)
            away = np.linalg.norm(self.cop[begin : end + 1] - place, axis=1)
            sample = begin + int(np.argmin(away)) if np.isfinite(nearest) else -1
            reached = bool(nearest < self.settings.landmark_radius)
            found.append(
                Target(index + 1, place, float(nearest), float(away.min()), reached, sample)
            )
            begin = end
        return tuple(found)

    @property
    def marks(self) -> tuple[TargetMark, ...]:
        """The targets as figures show them."""
        return marks_of(self.targets, self.settings.landmark_radius)

    def placed(self, foot: int, sample: int, points: FloatArray) -> FloatArray:
        """Points (k, 2) of a sole seen from above at a sample [m]."""
        rotation, place = self.soles
        return points @ rotation[sample, foot, :2, :2].T + place[sample, foot, :2]

    @cached_property
    def hulls(self) -> list[FloatArray]:
        """Corners (h, 2) of the hull of both sensing polygons, once for each double support [m]."""
        found: list[FloatArray] = []
        for stand in self.stands:
            if stand.feet != BOTH:
                continue
            corners = [
                self.placed(side, stand.begin, foot.sensing_polygon)
                for side, foot in enumerate(self.robot.feet)
            ]
            hull = shapely.MultiPoint(np.vstack(corners)).convex_hull
            ring = shapely.get_coordinates(hull)
            if not any(one.shape == ring.shape and np.allclose(one, ring, atol=1e-3)
                       for one in found):  # fmt: skip
                found.append(ring)
        return found

    def _in_world(self, place: FloatArray, sample: int) -> FloatArray:
        """A place (2,) in the left sole's frame where it is when the feet next stand [m].

        Targets of a part in which the left foot moves are given from where it comes down. A sample
        at the border of two parts is the last one of the first.
        """
        stand = next(one for one in self.stands if sample <= one.end)
        rotation, origin = (pose[stand.end - 1, 0] for pose in self.soles)
        world: FloatArray = rotation[:2, :2] @ place[:2] + origin[:2]
        return world

    def _switches(self) -> list[int]:
        """Samples at which each target was left: those at the planned states."""
        legs, samples, begin = self.motion.positions[:, self.robot.legs], [], 0
        for state in self.motion.path.states[self.motion.path.switches]:
            away = np.linalg.norm(legs[begin:] - state, axis=1)
            begin += int(np.argmin(away))
            samples.append(begin)
        return samples
