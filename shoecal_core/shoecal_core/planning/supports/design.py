"""Double supports that together promise the most: D- and E-optimal designs.

A design is judged by the information (observability) of its double supports plus the prior,
within the directions that any of the candidates sees: D-optimal is the largest determinant (the
smallest volume of uncertainty), E-optimal the largest smallest eigenvalue (the smallest worst
uncertainty). Sets are improved by exchange (Fedorov, Theory of Optimal Experiments, 1972): each
member in turn gives way to the candidate that improves the set most, until none does.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.observability import (
    Visit,
    information,
    observable,
    prior_information,
)
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]

_RESTARTS = 8
"""Exchanges begin at so many random sets: each ends at a set that no one exchange improves."""
_ROUNDING = 1e-9
_SUBSETS = 20
"""A set with more ways to leave runs out for testing is judged as a whole."""


def _log_determinant(total: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.slogdet(total)[1])


def _smallest_eigenvalue(total: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.eigvalsh(total)[..., 0])


CRITERIA: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "d_optimal": _log_determinant,
    "e_optimal": _smallest_eigenvalue,
}
"""Of information (..., r, r), by the name of the choice; larger is better."""


class Candidates:
    """Double supports that can be visited, with what each will tell.

    Attributes:
        supports: g of them.
        parts: (g, r, r) information of each, within the directions that any of them sees.
    """

    def __init__(
        self,
        robot: Robot,
        shoe: Shoe,
        supports: Sequence[DoubleSupport],
        settings: PlannerSettings,
        criterion: str,
    ) -> None:
        """Forecast each candidate.

        Args:
            robot, shoe: who visits them.
            supports: the candidates.
            settings: of the forecast.
            criterion: name of the one that judges sets of them.
        """
        self.supports = tuple(supports)
        visits = [Visit.expected(robot, support, settings) for support in supports]
        parts = np.array([information(robot, shoe, visit, settings) for visit in visits])
        seen = observable(parts.sum(axis=0))
        self.parts = seen.T @ parts @ seen
        self._prior = seen.T @ prior_information(robot, shoe, settings) @ seen
        self._criterion = CRITERIA[criterion]

    def scores(self, kept: Sequence[int], trained: int) -> FloatArray:
        """(g,) how good the kept ones are with each candidate beside them.

        A set is as good as the worst `trained` of it. One that is kept counts for nothing.
        """
        with_it = [
            self._criterion(self._sum(rest) + self.parts)
            for rest in itertools.combinations(kept, trained - 1)
        ]
        without = [
            float(self._criterion(self._sum(rest)))
            for rest in itertools.combinations(kept, trained)
        ]
        scores: FloatArray = np.minimum(np.min(with_it, axis=0), min(without, default=np.inf))
        scores[list(kept)] = -np.inf
        return scores

    def _sum(self, indices: Sequence[int]) -> FloatArray:
        total: FloatArray = self._prior + self.parts[list(indices)].sum(axis=0)
        return total


def design(
    candidates: Candidates, count: int, trained: int, generator: np.random.Generator
) -> list[DoubleSupport]:
    """The best `count` of the candidates that exchanges find, in the candidates' order.

    Args:
        candidates: to choose from, at least `count`.
        count: of double supports.
        trained: so many of them must do when the others are left out.
        generator: draws where the exchanges begin.
    """
    judged = trained if math.comb(count, trained) <= _SUBSETS else count
    starts = [
        generator.choice(len(candidates.supports), count, replace=False).tolist()
        for _ in range(_RESTARTS)
    ]
    best = max((_exchanged(candidates, start, judged) for start in starts), key=lambda one: one[0])
    return [candidates.supports[index] for index in sorted(best[1])]


def _exchanged(candidates: Candidates, members: list[int], trained: int) -> tuple[float, list[int]]:
    """Score and members of a set that no single exchange improves."""
    score, position, unchanged = -np.inf, 0, 0
    while unchanged < len(members):
        scores = candidates.scores(members[:position] + members[position + 1 :], trained)
        score, best = float(scores[members[position]]), int(np.argmax(scores))
        # Gains by rounding are none.
        if scores[best] > score + _ROUNDING * abs(score):
            members[position], score, unchanged = best, float(scores[best]), 0
        unchanged += 1
        position = (position + 1) % len(members)
    return score, members
