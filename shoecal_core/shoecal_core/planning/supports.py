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
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.observability import Visit, best_rank, information, rank
from shoecal_core.planning.posture import StanceSolver, UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]

_POOLS = 3
"""How often the pool of double supports is enlarged before the range is given up."""


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
    # Rounded, so that 0.1 + 0.1 + 0.1 is written as 0.3.
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3).round(9)


def draw_supports(
    robot: Robot, shoe: Shoe, settings: PlannerSettings, count: int, seed: int
) -> list[DoubleSupport]:
    """Draw `count` double supports, the same ones for the same seed.

    Each is a point of the robot's discretised range where the feet do not collide, are far
    enough apart (paper's distance d) and the robot can stand, above most landmarks too. Each is
    the one of a few draws that is farthest from those kept before. Whichever `test_supports` of
    them are left out, the others fix every direction of gains and offsets that as many can fix;
    sets that do not are drawn again. (Fewer than `training_supports` are taken as they come.)

    Raises:
        SupportRangeError: when the range holds fewer than `count`.
        UnobservableError: when no set fixes what should be fixed.
    """
    if count < 1:
        raise SupportRangeError(f"{count} double supports asked for; ask for at least one")
    generator = np.random.default_rng(seed)
    usable = usable_supports(robot, settings, generator)
    pool = list(itertools.islice(usable, max(count, settings.support_pool)))
    if len(pool) < count:
        raise SupportRangeError(
            f"robot '{robot.name}': {len(pool)} of {count} double supports found where the feet "
            "neither collide nor are out of reach; widen support_range, or lower distance_min, "
            "foot_clearance, stance_margin or landmarks_in_reach"
        )
    if count < settings.training_supports:
        return _spread(pool, count, settings, generator)
    trained = max(settings.training_supports, count - settings.test_supports)
    possible = best_rank(robot, shoe, trained, settings)
    found = 0
    for _ in range(_POOLS):
        parts = {
            support: information(robot, shoe, Visit.expected(robot, support, settings), settings)
            for support in pool
        }
        for _ in range(settings.support_redraws):
            supports = _spread(pool, count, settings, generator)
            weakest = min(
                rank(np.sum([parts[support] for support in chosen], axis=0), settings)
                for chosen in itertools.combinations(supports, trained)
            )
            if weakest >= possible:
                return supports
            found = max(found, weakest)
        pool += itertools.islice(usable, settings.support_pool)
    raise UnobservableError(robot.name, found, possible, 2 * len(shoe.channels))


def usable_supports(
    robot: Robot, settings: PlannerSettings, generator: np.random.Generator
) -> Iterator[DoubleSupport]:
    """The double supports that pass all checks which concern one alone, in random order.

    These are the paper's draws: feet that do not collide and are far enough apart, and a robot
    that can stand there, above most landmarks too.
    """
    grid = generator.permutation(support_grid(robot))
    grid = grid[feet_distance(grid[:, :2], grid[:, 2], settings) > settings.distance_min]
    stance = StanceSolver(Legs(robot), settings)
    for point in grid:
        support = DoubleSupport(*(float(value) for value in point))
        clear = feet_gap(robot, support) >= settings.foot_clearance
        if clear and _reachable(robot, support, stance, settings):
            yield support


def _reachable(
    robot: Robot, support: DoubleSupport, stance: StanceSolver, settings: PlannerSettings
) -> bool:
    if not _stands(stance, support, None):
        return False
    landmarks = Contour.of(robot, support).corners
    # As soon as too many are out of reach, the others need no look.
    spare = len(landmarks) - settings.landmarks_in_reach
    failed = (landmark for landmark in landmarks if not _stands(stance, support, landmark))
    return len(list(itertools.islice(failed, spare + 1))) <= spare


def _stands(stance: StanceSolver, support: DoubleSupport, cop: FloatArray | None) -> bool:
    try:
        stance.solve(support, cop)
    except UnreachableError:
        return False
    return True


def _spread(
    pool: list[DoubleSupport],
    count: int,
    settings: PlannerSettings,
    generator: np.random.Generator,
) -> list[DoubleSupport]:
    """`count` of the pool, each the one of a few draws that is farthest from those before."""
    places = np.array([(support.dx, support.dy, support.dtheta) for support in pool])
    kept: list[int] = []
    for _ in range(count):
        left = np.setdiff1d(np.arange(len(pool)), kept)
        drawn = generator.permutation(left)[: settings.support_candidates]
        apart = places[drawn, None] - places[kept]
        distances = feet_distance(apart[..., :2], apart[..., 2], settings)
        kept.append(int(drawn[np.argmax(distances.min(axis=1, initial=np.inf))]))
    return [pool[index] for index in kept]
