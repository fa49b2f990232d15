"""Which double supports a robot can be asked to visit (paper, section IV-A)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.posture import StanceSolver, UnreachableError, middle
from shoecal_core.planning.reach import obstacle
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.standing import feet_gap

_MOVED_IN = 0.5
"""Of the way to the middle between the feet; a landmark moved in by more is out of reach."""

_SURELY_IN = 0.45
"""Of that way. Sharing is wider in some postures than in others, and motions use the one nearest to
the robot's own: a landmark that another one reaches with more than this is looked at in that one.
"""


@dataclass
class Tally:
    """What became of double supports that were looked at.

    Attributes:
        near: the feet overlap or are too near each other.
        unreachable: the robot cannot stand there.
        landmarks: it can, but not above enough landmarks.
        usable: it can be asked to stand there.
    """

    near: int = 0
    unreachable: int = 0
    landmarks: int = 0
    usable: int = 0

    def __str__(self) -> str:
        return (
            f"{self.near} with feet too near, {self.unreachable} out of reach, {self.landmarks} "
            f"with landmarks out of reach, {self.usable} usable"
        )

    @property
    def cure(self) -> str:
        """Of feet that are too near each other; empty where something else rules most out."""
        others = max(self.unreachable, self.landmarks)
        if self.near == others == 0:
            return "widen support_range"
        if self.near > others:
            return "widen support_range, or lower distance_min or foot_clearance"
        return ""


class SupportRangeError(ShoecalError):
    """A range that does not hold the double supports that are wanted.

    Attributes:
        tally: of those that were looked at.
    """

    def __init__(self, feasible: Feasible, found: int, wanted: int) -> None:
        self.tally = feasible.tally
        why = f"; {self.tally.cure}" if self.tally.cure else f": {feasible.ruled_out()}"
        super().__init__(
            f"robot '{feasible.robot.name}': {found} of {wanted} double supports found where the "
            f"feet neither collide nor are out of reach (looked at: {self.tally}){why}"
        )


def feet_distance(
    way: FloatArray, yaw: FloatArray | float, settings: PlannerSettings
) -> FloatArray:
    """The paper's distance d = w_d |(dx, dy)| + w_o |dtheta|.

    Args:
        way: (..., 2) [m].
        yaw: (...) [rad].
        settings: the weights.
    """
    length: FloatArray = np.linalg.norm(way, axis=-1)
    turn = settings.orientation_weight * np.abs(yaw)
    return settings.distance_weight * length + turn


def support_grid(robot: Robot) -> FloatArray:
    """(g, 3) every dx, dy, dtheta of the robot's discretised range [m, m, rad]."""
    span = robot.support_range
    axes = [
        low + step * np.arange(np.floor((high - low) / step + 1e-9) + 1)
        for low, high, step in zip(span.lower, span.upper, span.step, strict=True)
    ]
    # Rounded, so that 0.1 + 0.1 + 0.1 is written as 0.3.
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3).round(9)


@dataclass(frozen=True)
class _Miss:
    """A double support that the robot cannot be asked to visit.

    Attributes:
        landmark: (2,) that it does not reach, left sole's frame [m]; None: it cannot stand there.
    """

    support: DoubleSupport
    landmark: FloatArray | None


class Feasible:
    """The double supports of one robot that pass all checks which concern one alone.

    They are points of its discretised range where the feet do not collide and are far enough
    apart (paper's distance d), and where the robot can stand, above most landmarks too; with
    `one_foot` also on one foot.

    Attributes:
        robot, settings: whose they are.
        tally: of all that have been looked at.
    """

    def __init__(self, robot: Robot, settings: PlannerSettings) -> None:
        self.robot, self.settings = robot, settings
        self.tally = Tally()
        self._stance = StanceSolver(Legs(robot), settings)
        self._misses: list[_Miss] = []

    def draw(self, generator: np.random.Generator) -> Iterator[DoubleSupport]:
        """All of them in random order: the paper's draws."""
        return (support for support in self.shuffled(generator) if self.can_stand(support))

    def shuffled(self, generator: np.random.Generator) -> Iterator[DoubleSupport]:
        """All of `apart` in random order."""
        return self._apart(generator.permutation(support_grid(self.robot)))

    def apart(self) -> list[DoubleSupport]:
        """All whose feet neither collide nor are too near; not in each the robot can stand."""
        return list(self._apart(support_grid(self.robot)))

    def can_stand(self, support: DoubleSupport) -> bool:
        """Whether the robot can stand there, and above enough landmarks."""
        try:
            posture = self._stance.near(support)
        except UnreachableError:
            self.tally.unreachable += 1
            self._misses.append(_Miss(support, None))
            return False
        landmarks = Contour.of(self.robot, support).corners
        # As soon as too many are out of reach, the others need no look.
        spare = len(landmarks) - self.settings.landmarks_in_reach
        failed = (one for one in landmarks if not self._reaches(support, one, posture))
        missed = list(itertools.islice(failed, spare + 1))
        if len(missed) > spare:
            self.tally.landmarks += 1
            self._misses.append(_Miss(support, missed[-1]))
            return False
        if self.settings.one_foot and not self._on_one_foot(support):
            self.tally.unreachable += 1
            return False
        self.tally.usable += 1
        return True

    def ruled_out(self) -> str:
        """What rules out most of those that were looked at, by the one next to normal standing."""
        on_feet = self.tally.unreachable >= self.tally.landmarks
        misses = [miss for miss in self._misses if (miss.landmark is None) == on_feet]
        if not misses:
            return "one foot cannot carry the weight; widen support_range, or turn one_foot off"
        miss = min(misses, key=lambda one: self._from_neutral(one.support))
        pose = FootPose.of(miss.support)
        inward = 0.0 if miss.landmark is None else _MOVED_IN
        found = obstacle(
            self.robot, lambda loose: self._stance.loosened(pose, miss.landmark, inward, loose)
        )
        where = f"with the right foot at {miss.support}"
        if miss.landmark is not None:
            x, y = 1e3 * miss.landmark
            where = f"with the CoP at the landmark ({x:.0f}, {y:.0f}) mm and {where[5:]}"
        return f"{where}, {found.what}; {found.cure}"

    def _from_neutral(self, support: DoubleSupport) -> float:
        """Steps of the range between a double support and normal standing."""
        span = self.robot.support_range
        place = np.array([support.dx, support.dy, support.dtheta])
        return float(np.linalg.norm((place - span.neutral) / span.step))

    def _apart(self, grid: FloatArray) -> Iterator[DoubleSupport]:
        distances = feet_distance(grid[:, :2], grid[:, 2], self.settings)
        for point, distance in zip(grid, distances, strict=True):
            support = DoubleSupport(*(float(value) for value in point))
            if (
                distance > self.settings.distance_min
                and feet_gap(self.robot, support) >= self.settings.foot_clearance
            ):
                yield support
            else:
                self.tally.near += 1

    def _on_one_foot(self, support: DoubleSupport) -> bool:
        """Also where a step to there ends wider: the robot has to get away again."""
        wider = replace(support, dy=support.dy - self.settings.step_error)
        try:
            self._stance.require_one_foot(wider, self.robot.posture)
        except UnreachableError:
            return False
        return True

    def _reaches(self, support: DoubleSupport, landmark: FloatArray, start: FloatArray) -> bool:
        """Whether the CoP comes to a landmark (2,) [m], or to one moved in a little.

        Looked for from leg angles (k,) at first: where it does come there, that takes least work.
        """
        pose, posture = FootPose.of(support), self.robot.posture
        if self._stance.reaches(pose, landmark, _SURELY_IN, start):
            return True
        place = self._stance.within_reach(pose, landmark[None], posture)[0]
        whole = np.linalg.norm(middle(self.robot, support) - landmark)
        return bool(np.linalg.norm(place - landmark) <= _MOVED_IN * whole)
