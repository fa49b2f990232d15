"""Drawing the double supports of one calibration (paper, section IV-A)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.observability import best_rank, information, rank
from shoecal_core.planning.posture import StanceSolver, UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]


class SupportRangeError(ShoecalError):
    """A range that does not hold the double supports that are wanted."""


class UnobservableError(ShoecalError):
    """A range whose double supports leave directions open that others would fix.

    Attributes:
        rank: the best that was found.
        possible: what far-apart double supports of differing yaw fix.
    """

    def __init__(self, robot: str, found: int, possible: int, parameters: int) -> None:
        self.rank = found
        self.possible = possible
        super().__init__(
            f"robot '{robot}': the double supports drawn fix {found} of {possible} observable "
            f"directions ({parameters} gains and offsets); widen support_range.dtheta_rad so that "
            "the yaw between the feet differs, or draw more supports"
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


def feet_gap(robot: Robot, support: DoubleSupport) -> float:
    """Gap between the outlines of the two feet, zero where they touch or overlap [m]."""
    left, right = (foot.outline for foot in robot.feet)
    gap = shapely.Polygon(left).distance(shapely.Polygon(support.right_to_left(right)))
    return float(gap)


def support_grid(robot: Robot) -> FloatArray:
    """(g, 3) every dx, dy, dtheta of the robot's discretised range [m, m, rad]."""
    span = robot.support_range
    axes = [
        low + step * np.arange(np.floor((high - low) / step + 1e-9) + 1)
        for low, high, step in zip(span.lower, span.upper, span.step, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def draw_supports(
    robot: Robot, shoe: Shoe, settings: PlannerSettings, count: int, seed: int
) -> list[DoubleSupport]:
    """Draw `count` double supports, the same ones for the same seed.

    Each is a point of the robot's discretised range where the feet do not collide, are far
    enough apart (paper's distance d) and the robot can stand. Each is the one of a few draws
    that is farthest from those kept before. Whichever `test_supports` of them are left out,
    the others fix every direction of gains and offsets that as many can fix; sets that do not
    are drawn again. (Fewer than `training_supports` are taken as they come.)

    Raises:
        SupportRangeError: when the range holds fewer than `count`.
        UnobservableError: when no set fixes what should be fixed.
    """
    if count < 1:
        raise SupportRangeError(f"{count} double supports asked for; ask for at least one")
    generator = np.random.default_rng(seed)
    sampler = _Sampler(robot, settings, generator)
    if count < settings.training_supports:
        return sampler.spread(count)
    trained = max(settings.training_supports, count - settings.test_supports)
    possible = best_rank(robot, shoe, trained, settings)
    found = 0
    for _ in range(settings.support_redraws):
        supports = sampler.spread(count)
        parts = [information(robot, shoe, support, settings) for support in supports]
        weakest = min(
            rank(np.sum(chosen, axis=0), settings)
            for chosen in itertools.combinations(parts, trained)
        )
        if weakest >= possible:
            return supports
        found = max(found, weakest)
    raise UnobservableError(robot.name, found, possible, 2 * len(shoe.channels))


class _Sampler:
    """Draws from the points of the range that pass all checks, found as they are needed."""

    def __init__(
        self, robot: Robot, settings: PlannerSettings, generator: np.random.Generator
    ) -> None:
        self._robot = robot
        self._settings = settings
        self._generator = generator
        grid = support_grid(robot)
        self._grid = grid[feet_distance(grid[:, :2], grid[:, 2], settings) > settings.distance_min]
        self._stance = StanceSolver(Legs(robot), settings)
        self._usable: dict[int, bool] = {}

    def spread(self, count: int) -> list[DoubleSupport]:
        """`count` different points, each chosen far from those before."""
        kept: list[int] = []
        for _ in range(count):
            fresh = (index for index in self._shuffled() if index not in kept)
            drawn = list(itertools.islice(fresh, self._settings.support_candidates))
            if not drawn:
                raise SupportRangeError(
                    f"robot '{self._robot.name}': {len(kept)} of {count} double supports found "
                    "where the feet neither collide nor are out of reach; widen support_range, "
                    "or lower distance_min, foot_clearance or stance_margin"
                )
            kept.append(max(drawn, key=lambda index: self._isolation(index, kept)))
        return [DoubleSupport(*(float(value) for value in self._grid[index])) for index in kept]

    def _shuffled(self) -> Iterator[int]:
        order = self._generator.permutation(len(self._grid))
        return (int(index) for index in order if self._is_usable(int(index)))

    def _isolation(self, index: int, kept: list[int]) -> float:
        if not kept:
            return 0.0
        difference = self._grid[kept] - self._grid[index]
        return float(feet_distance(difference[:, :2], difference[:, 2], self._settings).min())

    def _is_usable(self, index: int) -> bool:
        if index not in self._usable:
            support = DoubleSupport(*(float(value) for value in self._grid[index]))
            clear = feet_gap(self._robot, support) >= self._settings.foot_clearance
            self._usable[index] = clear and self._reachable(support)
        return self._usable[index]

    def _reachable(self, support: DoubleSupport) -> bool:
        try:
            self._stance.solve(support)
        except UnreachableError:
            return False
        return True
