"""Which directions of gains and offsets data fix, and which double support would fix the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.observability import (
    Visit,
    information,
    observable,
    prior_information,
    rank,
    reference_information,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.directions import describe_direction
from shoecal_core.shoe.shoe import Shoe

NEXT_STEPS = 1.0
"""Of the range, by which double supports next to each other differ at most in each direction."""
CANDIDATES = 200
"""Double supports looked at for the best to add: with more the best hardly gets better."""


@dataclass(frozen=True)
class WeakDirection:
    """A direction of the parameters that the data leave open, though others could fix it.

    Attributes:
        words: what changes along it.
        uncertainty: relative, infinite where the data say nothing.
    """

    words: str
    uncertainty: float


@dataclass(frozen=True)
class Identifiability:
    """What some data fix, if the model errs as expected.

    Attributes:
        uncertainties: (r,) by the data alone along the r directions that any data see, smallest
            first, infinite where these say nothing; gains relative to one, offsets to a
            channel's even share of the weight.
        rank: how many of them are fixed.
        possible: how many far-apart double supports of differing yaw would fix; never below `rank`.
        weak: those that are not fixed.
    """

    uncertainties: FloatArray
    rank: int
    possible: int
    weak: tuple[WeakDirection, ...]

    @property
    def singular_values(self) -> FloatArray:
        """(r,) of the whitened Jacobian, largest first."""
        values: FloatArray = 1.0 / self.uncertainties
        return values

    @property
    def weak_by_words(self) -> dict[str, list[float]]:
        """Uncertainties of those that are not fixed, by what changes along them."""
        found: dict[str, list[float]] = {}
        for weak in self.weak:
            found.setdefault(weak.words, []).append(weak.uncertainty)
        return found

    def to_json(self) -> dict[str, object]:
        """For result files; an infinite uncertainty is null."""
        return {
            "singular_values": self.singular_values.tolist(),
            "rank": self.rank,
            "possible_rank": self.possible,
            "weak_directions": [
                {
                    "direction": weak.words,
                    "uncertainty": weak.uncertainty if np.isfinite(weak.uncertainty) else None,
                }
                for weak in self.weak
            ],
        }


def identifiability(
    robot: Robot, shoe: Shoe, known: FloatArray, settings: PlannerSettings
) -> Identifiability:
    """What data of this information fix.

    Args:
        robot, shoe: who is calibrated, with n channels.
        known: (2n, 2n) of `information`, or of a fit by `relative_information`.
        settings: of planning.
    """
    reference = reference_information(robot, shoe, settings.training_supports, settings)
    seen = observable(reference)
    values, vectors = np.linalg.eigh(seen.T @ known @ seen)
    order = np.argsort(-values)
    spread = _deviations(values[order], float(np.trace(known)))
    directions = (seen @ vectors[:, order]).T
    fixed = spread < settings.fixed_below
    return Identifiability(
        uncertainties=spread,
        rank=int(fixed.sum()),
        possible=max(int(fixed.sum()), rank(reference, settings)),
        weak=tuple(
            WeakDirection(describe_direction(shoe, direction), float(uncertainty))
            for direction, uncertainty in zip(directions[~fixed], spread[~fixed], strict=True)
        ),
    )


def total_information(robot: Robot, shoe: Shoe, visits: Sequence[Visit]) -> FloatArray:
    """(2n, 2n) of several double supports together."""
    total = np.zeros((2 * len(shoe.channels), 2 * len(shoe.channels)))
    for visit in visits:
        total += information(robot, shoe, visit)
    return total


def best_addition(
    robot: Robot, shoe: Shoe, known: FloatArray, settings: PlannerSettings
) -> DoubleSupport | None:
    """The double support of the robot's range that makes the worst direction least uncertain.

    None where the robot can stand in none. Arguments, `known` (2n, 2n), as of `identifiability`.
    """
    feasible = Feasible(robot, settings)
    everywhere = feasible.apart()
    kept = np.random.default_rng(0).permutation(len(everywhere))[:CANDIDATES]
    supports = [everywhere[index] for index in sorted(kept.tolist())]
    parts = np.array(
        [information(robot, shoe, Visit.expected(robot, support, settings)) for support in supports]
    )
    seen = observable(reference_information(robot, shoe, settings.training_supports, settings))
    known = known + prior_information(robot, shoe)
    scores = np.linalg.eigvalsh(seen.T @ (known + parts) @ seen)[:, 0]
    places = np.array([(one.dx, one.dy, one.dtheta) for one in supports]) / robot.support_range.step
    tried = np.zeros((0, 3))
    for index in np.argsort(-scores).tolist():
        support: DoubleSupport = supports[index]
        # The best are the widest, most of them out of reach, and so are those next to these.
        if np.all(np.abs(tried - places[index]) <= NEXT_STEPS, axis=1).any():
            continue
        if feasible.can_stand(support):
            return support
        tried = np.vstack((tried, places[index]))
    return None


def _deviations(values: FloatArray, size: float) -> FloatArray:
    """Standard deviations of eigenvalues, infinite where these are rounding at this size."""
    seen = values > size * len(values) * np.finfo(float).eps
    return np.where(seen, 1.0 / np.sqrt(np.where(seen, values, 1.0)), np.inf)
