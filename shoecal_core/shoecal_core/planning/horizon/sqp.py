"""The fast solver: sequential quadratic programs.

Their second derivatives are Gauss-Newton's at first, then the Lagrangian's (Nocedal and Wright,
"Numerical optimization", chapter 18). From a near guess a few programs are enough, and full
steps nearly always do; a filter (Fletcher and Leyffer, "Nonlinear programming without a penalty
function", 2002) refuses the others. Where this solver fails, another has to step in.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.linearisation import (
    Curvature,
    Inequalities,
    Linearisation,
    Linearised,
)
from shoecal_core.planning.horizon.problem import TASKS, HorizonProblem, HorizonSolution
from shoecal_core.planning.horizon.quadratic_program import NewtonStep, QuadraticProgram
from shoecal_core.planning.legs import BALANCE

_ITERATIONS = 30
"""More are not worth it: interior points are surer then."""
_OPTIMAL = 1e-7
"""Of the cost; a smaller gain is none."""
_FEASIBLE = 1e-8
"""m, rad, N m; a smaller violation is none."""
_NEARLY, _WON = 0.05, 0.1
"""Of the cost: where less is left to gain, or more was won, a way that ends nowhere ends near
enough to an optimum for the few states that are taken of it. IPOPT hardly ever gets further: of 34
such problems of a robot on one foot it solved none, in two seconds each."""
_STEP = 1e-4
"""rad; a shorter step is none."""
_SHORT = 1e-3
"""rad; a shorter step needs no guard: what it does to cost and violation is lost in rounding."""
_CONTRACTION = 0.3
"""From one step to the next, before two are known."""
_SHORTENINGS = 7
_MARGIN = 1e-3
"""By which the filter wants to see things better."""
_ROUNDING = 1e-12
"""Of the cost."""
_PROJECTIONS = 5
_PROJECTED = 1e-10
"""m, rad; what is left between the feet of projected states and their places."""


class SqpSolver:
    """Solves a horizon's problem from a near guess in a few small quadratic programs.

    To an optimum, or nearly where it lies at a kink (status `Solved_Nearly`). One at a time:
    memory is used again.
    """

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        settings = collocation.settings
        count, size = settings.horizon, len(collocation.lower)
        self._edges = collocation.edges
        rows = self._edges + len(collocation.legs.robot.collision_pairs) + BALANCE + 3 * size
        self._linearised = Linearisation(collocation)
        self._curvature = Curvature(collocation)
        self._program = QuadraticProgram(count, size, rows, settings.transition_weight)

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        """States (N, k) from a guess of them (N, k) [rad]; see Solver."""
        collocation = self._collocation
        problem = dataclasses.replace(problem, scene=problem.scene.padded(self._edges))
        limits = collocation.limits(problem)
        descent = _Descent(collocation, problem, Inequalities(problem, limits), self._linearised)
        descent.begin(np.clip(guess, limits.lower, limits.upper))

        status, done, iteration = "No_Progress", False, 0
        while iteration < _ITERATIONS and not done:
            iteration += 1
            step = self._proposed(problem, descent)
            if step is None:
                status = "Programme_Failed"
                break
            if not descent.take(step):
                break
            if descent.arrived:
                status, done = "Solved", True
        states = descent.linear.states
        if status == "No_Progress" and descent.nearly:
            # Torques and distances have kinks, and steps may jump from one side to the other.
            states = self._projected(problem, descent)
            status, done = "Solved_Nearly", True
        return collocation.certified(problem, states, status, iteration, done, limits)

    def _proposed(self, problem: HorizonProblem, descent: _Descent) -> NewtonStep | None:
        """The next step, with the Lagrangian's second derivatives where prices are known."""
        linear, inequalities, before = descent.linear, descent.inequalities, descent.step
        if before is None:
            return self._program.solve(problem, linear, inequalities)
        prices = self._program.multipliers(problem, inequalities, before)
        aim = problem.aim
        prices[:, :TASKS] += 2.0 * aim.weights * (linear.values.tasks - aim.targets)
        curvature = self._curvature(linear.states, problem.scene, prices)
        return self._program.solve(problem, linear, inequalities, before, curvature)

    def _projected(self, problem: HorizonProblem, descent: _Descent) -> FloatArray:
        """States (N, k) moved onto all constraints."""
        states, inequalities = descent.linear.states, descent.inequalities
        for _ in range(_PROJECTIONS):
            linear = self._linearised(states, problem.scene)
            feet = float(np.abs(linear.values.foot_error).max())
            if feet < _PROJECTED and inequalities.violation(linear) < _FEASIBLE:
                break
            states = states + self._program.nearest(linear, inequalities)
        return states


class _Descent:
    """The way from a guess to an optimum, guarded by a filter."""

    def __init__(
        self,
        collocation: Collocation,
        problem: HorizonProblem,
        inequalities: Inequalities,
        linearised: Linearisation,
    ) -> None:
        self._collocation = collocation
        self._problem = problem
        self.inequalities = inequalities
        self._linearised = linearised
        self.step: NewtonStep | None = None
        self._filter: list[tuple[float, float]] = []
        self._length, self._first = np.inf, np.inf
        self.arrived = self.nearly = False

    def begin(self, states: FloatArray) -> None:
        """Start from states (N, k) [rad]."""
        self.linear, cost, violation = self._at(states)
        self._first = cost
        self._filter.append((cost, violation))

    def take(self, step: NewtonStep) -> bool:
        """Go as much of a step as the filter lets pass; False where it lets nothing."""
        length = float(np.abs(step.change).max())
        for shortening in range(_SHORTENINGS):
            part = 0.5**shortening
            linear, cost, violation = self._at(self.linear.states + part * step.change)
            if length < _SHORT or self._passes(cost, violation):
                break
        else:
            return False
        self._filter.append((cost, violation))
        contraction = min(1.0, length / self._length) if np.isfinite(self._length) else _CONTRACTION
        # What is left of a linearly convergent method's gain after this step.
        left = contraction**2 * abs(step.gain)
        near = part == 1.0 and (left < _OPTIMAL * cost or length < _STEP)
        self.arrived = near and violation < _FEASIBLE
        self.nearly = abs(step.gain) < _NEARLY * cost or cost < (1.0 - _WON) * self._first
        self.linear, self._length = linear, part * length
        self.step = step
        return True

    def _passes(self, cost: float, violation: float) -> bool:
        """Does it improve on everything before, either in cost or in violation?"""
        beyond = max(0.0, violation - _FEASIBLE)
        for other_cost, other_violation in self._filter:
            other = max(0.0, other_violation - _FEASIBLE)
            cheaper = cost <= other_cost + _ROUNDING * abs(other_cost) - _MARGIN * other
            if not cheaper and not beyond < (1.0 - _MARGIN) * other:
                return False
        return True

    def _at(self, states: FloatArray) -> tuple[Linearised, float, float]:
        """Linearised states, their cost and violation."""
        linear = self._linearised(states, self._problem.scene)
        cost = self._collocation.cost(self._problem, states, linear.values)
        return linear, cost, self.inequalities.violation(linear)
