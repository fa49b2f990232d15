"""The fast solver: sequential quadratic programmes with Gauss-Newton second derivatives.

An active set hardly changes from one programme to the next, nor from one horizon to the next.
Where this solver fails, another has to step in.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.collocation import Collocation, HorizonProblem, Solution
from shoecal_core.planning.linearisation import Inequalities, Linearisation, Linearised
from shoecal_core.planning.programme import Programme

FloatArray = NDArray[np.float64]

_ITERATIONS = 12
"""More are not worth it: interior points are surer then."""
_STEP = 1e-3
"""rad; after a step this small, what is left of the curvature is far below the tolerance."""
_SHORTENINGS = 4


class SqpSolver:
    """Solves a horizon's problem from a near guess in a few small quadratic programmes.

    One at a time: memory is used again.
    """

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        count, size = collocation.settings.horizon, len(collocation.lower)
        self._edges = collocation.edges
        rows = self._edges + len(collocation.legs.robot.collision_pairs) + 3 * size
        self._linearised = Linearisation(collocation)
        self._programme = Programme(count, size, rows, collocation.settings.transition_weight)

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """See Solver."""
        collocation = self._collocation
        problem = dataclasses.replace(problem, scene=problem.scene.padded(self._edges))
        limits = collocation.limits(problem)
        inequalities = Inequalities(problem, limits)
        linear = self._linearised(problem, np.clip(guess, limits.lower, limits.upper))
        penalty = self._penalty(problem, linear)

        def merit_of(tried: Linearised) -> float:
            cost = collocation.cost(problem, tried.states, tried.values)
            return cost + penalty * inequalities.violation(tried)

        merit = merit_of(linear)
        for iteration in range(1, _ITERATIONS + 1):
            step = self._programme.solve(problem, linear, inequalities)
            if step is None:
                return collocation.certified(
                    problem, linear.states, "Programme_Failed", iteration, False
                )
            for shortening in range(_SHORTENINGS):
                tried = self._linearised(problem, linear.states + step.change / 2.0**shortening)
                merit_tried = merit_of(tried)
                if merit_tried < merit:
                    break
            done = float(np.abs(step.change).max()) < _STEP
            if merit_tried < merit:
                linear, merit = tried, merit_tried
            elif not done:
                return collocation.certified(
                    problem, linear.states, "Step_Rejected", iteration, False
                )
            if done:
                return collocation.certified(problem, linear.states, "Solved", iteration, True)
        return collocation.certified(
            problem, linear.states, "Iterations_Exceeded", _ITERATIONS, False
        )

    def _penalty(self, problem: HorizonProblem, linear: Linearised) -> float:
        """Weight of violations in the merit: well above what they could buy in cost."""
        aim = problem.aim
        away = np.abs(linear.values.tasks - aim.targets).max(axis=0)
        return float(20.0 * len(linear.states) * np.max(aim.weights * (away + 0.01)))
