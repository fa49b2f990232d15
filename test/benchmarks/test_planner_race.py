from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner_cases import Solve, Span
from planner_race import FEASIBLE, Times, disagreements, gaps, race, share_converged
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.horizon.problem import Aim, HorizonProblem, Scene, Solution
from shoecal_core.planning.legs import FootPose

STILL = np.zeros(3)
PROBLEM = HorizonProblem(
    STILL,
    STILL,
    Aim(np.zeros((1, 5)), np.zeros(5)),
    Scene(
        FootPose.of(DoubleSupport(0.0, -0.1, 0.0)).parameters[None],
        np.array([[0.0, 1.0]]),
        np.zeros((1, 3, 2)),
        np.zeros((1, 3)),
        STILL,
    ),
)


def solve(cost: float, violation: float = 0.0, seconds: float = 1.0) -> Solve:
    solution = Solution(STILL[None], cost, violation, True, "Solved", 1)
    return Solve(PROBLEM, STILL[None], solution, Span(seconds, seconds))


class Counting:
    """Tells whose turn it is, and takes one second longer each time."""

    def __init__(self, calls: list[str], name: str) -> None:
        self._calls, self._name, self._count = calls, name, 0

    def run(self, problem: HorizonProblem, guess: np.ndarray) -> tuple[Solution, Span]:
        assert problem is PROBLEM
        self._calls.append(f"{self._name}{guess[0, 0]:.0f}")
        self._count += 1
        return solve(1.0).solution, Span(float(self._count), float(self._count))


def test_solvers_take_turns_and_are_warm_when_their_time_is_taken() -> None:
    calls: list[str] = []
    racers = {name: Counting(calls, name) for name in "ab"}
    problems = [dataclasses.replace(solve(1.0), guess=STILL[None] + i) for i in range(2)]
    found = race(racers, problems)
    assert " ".join(calls) == "a0 a0 b0 b0 a0 a1 b0 b1"
    assert [one.span.cpu for one in found["a"]] == [2.0, 4.0]


@given(st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=50), st.floats(1.0, 100.0))
def test_a_solver_slower_by_one_factor_is_so_by_every_measure(
    seconds: list[float], factor: float
) -> None:
    fast = Times(np.array(seconds))
    slow = Times(factor * np.array(seconds))
    assert slow.ratios(fast) == pytest.approx((factor,) * 4)


def test_objectives_bought_by_violations_do_not_count_as_converged() -> None:
    best = np.full(4, 2.0)
    found = [solve(2.0), solve(2.0 + 1e-6), solve(1.99), solve(2.0, 2.0 * FEASIBLE)]
    np.testing.assert_allclose(gaps(found, best), [0.0, 5e-7, 5e-3, np.inf], rtol=1e-6)
    assert share_converged(found, best) == 0.5


def test_references_that_disagree_are_named() -> None:
    results = {"a": [solve(2.0), solve(3.0)], "b": [solve(2.0), solve(3.1)]}
    ((index, name, difference),) = disagreements(results, ("a", "b"))
    assert (index, name) == (1, "b")
    assert difference == pytest.approx(0.1 / 3.0)
