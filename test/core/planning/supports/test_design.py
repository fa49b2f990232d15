from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from core.planning.bodies import Body
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.settings import CHOICES, PlannerSettings
from shoecal_core.planning.supports.design import CRITERIA, Candidates, design
from shoecal_core.planning.supports.feasible import support_grid
from shoecal_core.planning.supports.observability import (
    Visit,
    information,
    prior_information,
    uncertainties,
)

SETTINGS = PlannerSettings()
FEW = 9


def some_supports(body: Body, count: int = FEW) -> list[DoubleSupport]:
    """Anywhere in the range; whether the robot can stand there does not matter here."""
    grid = np.random.default_rng(0).permutation(support_grid(body.robot))[:count]
    return [DoubleSupport(*(float(value) for value in point)) for point in grid]


def total(body: Body, supports: tuple[DoubleSupport, ...]) -> NDArray[np.float64]:
    """Information and prior of some double supports."""
    visits = [Visit.expected(body.robot, support, SETTINGS) for support in supports]
    parts = [information(body.robot, body.shoe, visit, SETTINGS) for visit in visits]
    prior = prior_information(body.robot, body.shoe, SETTINGS)
    return np.asarray(np.sum([*parts, prior], axis=0))


def test_every_choice_but_one_has_its_criterion() -> None:
    assert {"spread", *CRITERIA} == set(CHOICES)


@pytest.mark.parametrize("trained", [2, 3])
def test_no_set_promises_a_smaller_volume(body: Body, trained: int) -> None:
    """Against all sets of three, judged by the determinant over all parameters."""
    supports = some_supports(body)
    candidates = Candidates(body.robot, body.shoe, supports, SETTINGS, "d_optimal")
    chosen = design(candidates, 3, trained, np.random.default_rng(0))

    def worst(members: tuple[DoubleSupport, ...]) -> float:
        parts = itertools.combinations(members, trained)
        return min(float(np.linalg.slogdet(total(body, part))[1]) for part in parts)

    best = max(worst(members) for members in itertools.combinations(supports, 3))
    assert worst(tuple(chosen)) == pytest.approx(best, rel=1e-9)


def test_no_set_promises_a_smaller_worst_uncertainty(nao: Body) -> None:
    """Patterns that nothing fixes stand at the end of all: the one before them counts."""
    supports = some_supports(nao)
    candidates = Candidates(nao.robot, nao.shoe, supports, SETTINGS, "e_optimal")
    chosen = design(candidates, 3, 3, np.random.default_rng(0))

    def worst(members: tuple[DoubleSupport, ...]) -> float:
        return float(uncertainties(total(nao, members))[-3])

    best = min(worst(members) for members in itertools.combinations(supports, 3))
    assert worst(tuple(chosen)) == pytest.approx(best, rel=1e-6)


def test_scores_are_of_the_worst_part(nao: Body) -> None:
    supports = some_supports(nao, 6)
    candidates = Candidates(nao.robot, nao.shoe, supports, SETTINGS, "d_optimal")
    scores = candidates.scores([0, 1, 2], 2)
    pairs = {
        pair: float(candidates.scores(pair[:1], 2)[pair[1]])
        for pair in itertools.combinations(range(6), 2)
    }
    for added in (3, 4, 5):
        among = itertools.combinations((0, 1, 2, added), 2)
        assert scores[added] == pytest.approx(min(pairs[pair] for pair in among))
    assert np.isneginf(scores[:3]).all()


def test_many_double_supports_are_judged_together(nao: Body) -> None:
    """More ways to leave some out than can be looked at one by one."""
    supports = some_supports(nao, 14)
    candidates = Candidates(nao.robot, nao.shoe, supports, SETTINGS, "d_optimal")
    chosen = design(candidates, 12, 8, np.random.default_rng(0))
    assert len(set(chosen)) == 12
