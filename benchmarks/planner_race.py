"""Several solvers on the same problems, in turns, and what their times say of each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from planner_cases import Solve, Span, Stopwatch
from shoecal_core.planning.horizon.problem import HorizonProblem, Solution, Solver

FloatArray = NDArray[np.float64]
Results = Mapping[str, Sequence[Solve]]
CONVERGED = 1e-6
"""Largest difference from the best objective known, as a share of it."""
SAME = 1e-6
"""Largest difference of two references' objectives, as a share of them, or of one."""
FEASIBLE = 1e-5
"""Largest violation with which an objective counts; a violation can buy a better one."""


class Racer(Protocol):
    """Solves a problem and tells how long it took."""

    def run(self, problem: HorizonProblem, guess: FloatArray) -> tuple[Solution, Span]:
        """Find states (N, k) from a guess of them (N, k) [rad]."""
        ...


@dataclass(frozen=True)
class InProcess:
    """A solver of this process."""

    solver: Solver

    def run(self, problem: HorizonProblem, guess: FloatArray) -> tuple[Solution, Span]:
        """See Racer."""
        watch = Stopwatch()
        solution = self.solver.solve(problem, guess)
        return solution, watch.read()


def race(
    racers: Mapping[str, Racer],
    problems: Sequence[Solve],
    told: Callable[[int], None] = lambda _: None,
) -> dict[str, list[Solve]]:
    """Every problem by all solvers before the next one, each from the recorded guess.

    Before its time is taken a solver solves the problem before once more (the first one itself):
    so its caches are as warm as in a closed loop, and what it keeps from solve to solve is the
    same.
    """
    solves: dict[str, list[Solve]] = {name: [] for name in racers}
    for index, recorded in enumerate(problems):
        before = problems[max(index - 1, 0)]
        for name, racer in racers.items():
            racer.run(before.problem, before.guess)
            solution, span = racer.run(recorded.problem, recorded.guess)
            solves[name].append(Solve(recorded.problem, recorded.guess, solution, span))
        told(index + 1)
    return solves


@dataclass(frozen=True)
class Times:
    """Of one solver's solves [s].

    Attributes:
        values: (P,) of each problem.
    """

    values: FloatArray

    @classmethod
    def of(cls, solves: Sequence[Solve], clock: str = "cpu") -> Times:
        return cls(np.array([getattr(solve.span, clock) for solve in solves]))

    @property
    def summary(self) -> tuple[float, float, float, float]:
        """Median, 95th and 99th percentile, sum [s]."""
        median, most, nearly_all = np.percentile(self.values, [50, 95, 99])
        return float(median), float(most), float(nearly_all), float(self.values.sum())

    def ratios(self, fast: Times) -> tuple[float, float, float, float]:
        """How many times longer than a fast solver.

        The median over problems of the ratio; the ratio of the 95th, of the 99th percentiles, and
        of the sums.
        """
        _, most, nearly_all, total = (
            one / other for one, other in zip(self.summary, fast.summary, strict=True)
        )
        return float(np.median(self.values / fast.values)), most, nearly_all, total


def best_known(judge: Solver, results: Results) -> FloatArray:
    """(P,) objectives of the optimum that a judge finds from the best of the solutions.

    Where it finds none, of the best itself.
    """
    best = []
    for solves in zip(*results.values(), strict=True):
        start = min(solves, key=_objective)
        judged = judge.solve(start.problem, start.solution.states)
        best.append(judged.cost if judged.converged else _objective(start))
    return np.array(best)


def _objective(solve: Solve) -> float:
    """Infinite where constraints are not kept."""
    solution = solve.solution
    return solution.cost if solution.violation <= FEASIBLE else np.inf


def gaps(solves: Sequence[Solve], best: FloatArray) -> FloatArray:
    """(P,) distance from the best objective, as a share of it.

    To either side: an objective below the optimum has been bought by a violation.
    """
    costs = np.array([_objective(solve) for solve in solves])
    gap: FloatArray = np.abs(costs / best - 1.0)
    return gap


def share_converged(solves: Sequence[Solve], best: FloatArray) -> float:
    """Of solves within CONVERGED of the best objective."""
    return float(np.mean(gaps(solves, best) <= CONVERGED))


def disagreements(results: Results, names: Sequence[str]) -> Iterator[tuple[int, str, float]]:
    """Problems whose objective differs between references: index, solver, difference."""
    for index, first in enumerate(results[names[0]]):
        for name in names[1:]:
            cost, other = first.solution.cost, results[name][index].solution.cost
            difference = abs(cost - other) / max(1.0, abs(cost))
            if not difference <= SAME:
                yield index, name, difference
