"""Drawing the double supports of one calibration (paper, section IV-A)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible, SupportRangeError, feet_distance
from shoecal_core.planning.supports.observability import Visit, best_rank, information, rank
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

SearchProgress = Callable[[int, int], None]
"""Takes how many double supports have been tried, and how many will be at most."""

_TRIES = 25
"""Double supports tried for each one wanted; a robot that stands in fewer is hardly fit for it."""
_REPORT_EVERY = 20
"""Tries between two calls of the progress function."""
_CANDIDATES = 6
"""Draws from which the double support farthest from those kept is taken."""
_REDRAWS = 100
"""Sets drawn from a pool before more double supports are looked for."""
_OTHERS = 10
"""Double supports that may stand in for one in which a motion cannot be done."""
_POOLS = 3
"""How often the pool of double supports is enlarged before the range is given up."""


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


class _Search:
    """Looks for double supports that a robot can be asked to visit, in random order."""

    def __init__(
        self, feasible: Feasible, generator: np.random.Generator, progress: SearchProgress
    ) -> None:
        self.feasible = feasible
        self._untried = feasible.shuffled(generator)
        self._progress = progress

    def pool(self, count: int, size: int) -> list[DoubleSupport]:
        """As many as `size` if they are found soon, at least `count`.

        Raises:
            SupportRangeError: when there are fewer.
        """
        pool = self.more(max(count, size))
        if len(pool) < count:
            raise SupportRangeError(self.feasible, len(pool), count)
        return pool

    def more(self, wanted: int) -> list[DoubleSupport]:
        """As many more; fewer where that takes too many tries."""
        found: list[DoubleSupport] = []
        most = _TRIES * wanted
        for tried, support in enumerate(itertools.islice(self._untried, most)):
            if tried % _REPORT_EVERY == 0:
                self._progress(tried, most)
            if self.feasible.can_stand(support):
                found.append(support)
                if len(found) == wanted:
                    break
        return found


def draw_supports(
    robot: Robot,
    shoe: Shoe,
    settings: PlannerSettings,
    count: int,
    seed: int,
    progress: SearchProgress = lambda _tried, _most: None,
) -> list[DoubleSupport]:
    """Draw `count` double supports, the same ones for the same seed.

    Each passes the checks of `Feasible`, and is the one of a few draws that is farthest from those
    kept before. Whichever `test_supports` of them are left out, the others fix every direction of
    gains and offsets that as many can fix; sets that do not are drawn again. Where a robot's range
    has no such set, the first ones fix every direction, those of `test_supports` left out. (Fewer
    than `training_supports` are taken as they come.)

    Args:
        robot, shoe, settings: who visits them.
        count: how many.
        seed: of the draw.
        progress: called during the search.

    Raises:
        SupportRangeError: when the range holds fewer than `count`, or hardly any.
        UnobservableError: when no set fixes what should be fixed.
    """
    if count < 1:
        raise ShoecalError(f"{count} double supports asked for; ask for at least one")
    generator = np.random.default_rng(seed)
    search = _Search(Feasible(robot, settings), generator, progress)
    pool = search.pool(count, settings.support_pool)
    if count < settings.training_supports:
        return _spread(pool, count, settings, generator)
    possible = best_rank(robot, shoe, trained_supports(count, settings), settings)
    found, trained = 0, trained_supports(count, settings)
    by_some: list[DoubleSupport] = []
    for _ in range(_POOLS):
        parts = _parts(robot, shoe, pool, settings)
        for _ in range(_REDRAWS):
            supports = _spread(pool, count, settings, generator)
            weakest = weakest_rank([parts[support] for support in supports], settings)
            if weakest >= possible:
                return supports
            found = max(found, weakest)
            by_some = by_some or _fixing_first(supports, parts, trained, possible, settings)
        pool += search.more(settings.support_pool)
    if by_some:
        return by_some
    raise UnobservableError(robot.name, found, possible, 2 * len(shoe.channels))


def _fixing_first(
    supports: Sequence[DoubleSupport],
    parts: Mapping[DoubleSupport, FloatArray],
    trained: int,
    possible: int,
    settings: PlannerSettings,
) -> list[DoubleSupport]:
    """The double supports, first as many as are trained that fix all; empty where none do."""
    for chosen in itertools.combinations(supports, trained):
        if rank(np.sum([parts[one] for one in chosen], axis=0), settings) >= possible:
            return [*chosen, *(one for one in supports if one not in chosen)]
    return []


def other_supports(
    robot: Robot, settings: PlannerSettings, taken: Collection[DoubleSupport], seed: int
) -> Iterator[DoubleSupport]:
    """Further double supports, for what cannot be done in one that was drawn.

    The same ones in the same order for the same seed; a few, and fewer where the range holds
    hardly any.

    Args:
        robot, settings: who visits them.
        taken: double supports that are none of them.
        seed: of the draw.
    """
    feasible = Feasible(robot, settings)
    untried = feasible.shuffled(np.random.default_rng([seed, 1]))
    usable = (
        support
        for support in itertools.islice(untried, _TRIES * _OTHERS)
        if support not in taken and feasible.can_stand(support)
    )
    yield from itertools.islice(usable, _OTHERS)


def trained_supports(count: int, settings: PlannerSettings) -> int:
    """How many of `count` double supports are sure to be fitted, however many are for testing."""
    if count < settings.training_supports:
        return count
    return max(settings.training_supports, count - settings.test_supports)


def weakest_rank(parts: Sequence[FloatArray], settings: PlannerSettings) -> int:
    """Number of directions that are identifiable without the most informative double supports.

    Args:
        parts: (2n, 2n) information of each double support.
        settings: of planning.
    """
    trained = trained_supports(len(parts), settings)
    return min(
        rank(np.sum(chosen, axis=0), settings) for chosen in itertools.combinations(parts, trained)
    )


def _parts(
    robot: Robot, shoe: Shoe, supports: Sequence[DoubleSupport], settings: PlannerSettings
) -> dict[DoubleSupport, FloatArray]:
    return {
        support: information(robot, shoe, Visit.expected(robot, support, settings))
        for support in supports
    }


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
        drawn = generator.permutation(left)[:_CANDIDATES]
        apart = places[drawn, None] - places[kept]
        distances = feet_distance(apart[..., :2], apart[..., 2], settings)
        kept.append(int(drawn[np.argmax(distances.min(axis=1, initial=np.inf))]))
    return [pool[index] for index in kept]
