"""The quadratic program of one step, in the directions that the feet leave free.

The foot transform leaves each state few of them (5 of 11 for a robot with a shared hip motor).
So the program is small and dense: 50 unknowns for ten states.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.active_set import active_set_solution
from shoecal_core.planning.horizon.linearisation import Inequalities, Linearised
from shoecal_core.planning.horizon.problem import FOOT_ROWS, HorizonProblem

_FEASIBLE = 1e-9
"""Largest violation of a row by a program's solution."""
_TOUCHED = 1e-7
"""A row nearer to its bound at the guess is thought to be active."""


@dataclass(frozen=True)
class FootConstraints:
    """A step is fixed + basis @ free, which puts the feet right whatever the free part is.

    Attributes:
        fixed: (N, k).
        basis: (N, k, f).
        factor, triangle: (N, k, 6), (N, 6, 6) of the feet's slopes, transposed.
    """

    fixed: FloatArray
    basis: FloatArray
    factor: FloatArray
    triangle: FloatArray

    @classmethod
    def of(cls, linear: Linearised) -> FootConstraints:
        """By orthogonal factors."""
        factor, triangle = np.linalg.qr(linear.foot.swapaxes(1, 2), mode="complete")
        across, triangle = factor[:, :, :FOOT_ROWS], triangle[:, :FOOT_ROWS]
        error = linear.values.foot_error[..., None]
        fixed = across @ np.linalg.solve(triangle.swapaxes(1, 2), -error)
        return cls(fixed[..., 0], factor[:, :, FOOT_ROWS:], across, triangle)

    def borne(self, gradient: FloatArray) -> FloatArray:
        """(N, 6) multipliers that take away what a gradient (N, k) has across the basis."""
        across = self.factor.swapaxes(1, 2) @ gradient[..., None]
        return np.linalg.solve(self.triangle, -across)[..., 0].astype(np.float64, copy=False)


@dataclass(frozen=True)
class NewtonStep:
    """What a program proposes.

    Attributes:
        change: (N, k) of the states [rad].
        gain: how much less the cost is after it, to second order.
        prices: (N, r) multipliers of the inequalities.
        linear: where it begins.
        feet: of those states.
    """

    change: FloatArray
    gain: float
    prices: FloatArray
    linear: Linearised
    feet: FootConstraints


class QuadraticProgram:
    """Solves programs of one shape, one after another: memory is used again.

    Where the active rows cannot be guessed from those before, DAQP finds them. On the programs of a
    NAO's motions (50 unknowns, 460 rows, processor time, medians) it took 0.4 ms, qpOASES 1.9,
    ProxQP 5.5, PIQP 12 and OSQP 90; the last two failed in a tenth of them.

    Attributes:
        count: N states.
    """

    def __init__(self, count: int, size: int, rows: int, transition_weight: float) -> None:
        """Take shapes.

        Args:
            count: N states.
            size: k angles each.
            rows: r inequalities each, transitions as the last k.
            transition_weight: Q_u.
        """
        self.count = count
        self._weight = transition_weight
        free = size - FOOT_ROWS
        # u[i] - u[i-1] = (difference @ q)[i] + what start and previous transition add.
        self._difference = np.eye(count) - 2.0 * np.eye(count, k=-1) + np.eye(count, k=-2)
        unknowns = count * free
        self._hessian, self._gradient = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        self._blocks = np.einsum("iaib->iab", self._hessian.reshape(count, free, count, free))
        # CasADi stores by columns: rows of this matrix belong to unknowns.
        matrix = np.zeros((count, free, count, rows))
        self._matrix = matrix.reshape(unknowns, -1)
        self._low, self._high = np.zeros((count, rows)), np.zeros((count, rows))
        # Rows of a state depend on it alone, transitions on the state before as well.
        self._own = np.einsum("iaib->iab", matrix)
        self._before = np.einsum("iaib->iab", matrix[:-1, :, 1:])[..., -size:]
        self._found, self._prices = np.zeros((count, free)), np.zeros((count, rows))
        self._solver = ca.conic(
            "program",
            "daqp",
            {
                "h": ca.Sparsity.dense(unknowns, unknowns),
                "a": ca.Sparsity.dense(count * rows, unknowns),
            },
            {"error_on_fail": False, "daqp": {"primal_tol": _FEASIBLE}},
        )
        # CasADi's stubs do not know what its buffers take.
        self._buffer: Any
        self._buffer, self._run = self._solver.buffer()
        # Neither copies nor conversions.
        self._endless = np.full(unknowns, np.inf)
        given = {
            "h": self._hessian, "g": self._gradient, "a": matrix, "lba": self._low,
            "uba": self._high, "lbx": -self._endless, "ubx": self._endless,
        }  # fmt: skip
        self._memory = list(given.values())
        for name, array in given.items():
            self._buffer.set_arg(self._solver.index_in(name), array.data)
        for name, array in (("x", self._found), ("lam_a", self._prices)):
            self._buffer.set_res(self._solver.index_out(name), array.data)

    def solve(
        self,
        problem: HorizonProblem,
        linear: Linearised,
        inequalities: Inequalities,
        before: NewtonStep | None = None,
        curvature: FloatArray | None = None,
    ) -> NewtonStep | None:
        """The step from states that `linear` describes; None where the program has none.

        Args:
            problem: whose cost.
            linear: where to start, states (N, k) [rad].
            inequalities: to be kept.
            before: the step that led there; the same rows are thought to be active.
            curvature: (N, k, k) what the constraints and the way to the target add to the
                Gauss-Newton Hessian.
        """
        feet = FootConstraints.of(linear)
        self._set_cost(problem, linear, feet)
        if curvature is not None:
            self._add(curvature, feet)
        change = self._solved(linear, inequalities, feet, before)
        if change is None:
            return None
        found = self._found.ravel()
        gain = -found @ (self._gradient + 0.5 * self._hessian @ found)
        return NewtonStep(change, float(gain), self._prices.copy(), linear, feet)

    def nearest(self, linear: Linearised, inequalities: Inequalities) -> FloatArray:
        """(N, k) shortest change that keeps everything to first order [rad].

        Where none does, the shortest that puts the feet right.
        """
        self._hessian[:], self._gradient[:] = np.eye(len(self._gradient)), 0.0
        feet = FootConstraints.of(linear)
        change = self._solved(linear, inequalities, feet)
        return feet.fixed if change is None else change

    def _solved(
        self,
        linear: Linearised,
        inequalities: Inequalities,
        feet: FootConstraints,
        before: NewtonStep | None = None,
    ) -> FloatArray | None:
        self._set_rows(linear, inequalities, feet)
        low, high = self._low.ravel(), self._high.ravel()
        if before is None:
            active = (high < _TOUCHED).astype(np.float64) - (low > -_TOUCHED)
        else:
            active = np.sign(before.prices.ravel())
        near = active_set_solution(
            self._hessian, self._gradient, self._matrix, low, high, active, _FEASIBLE
        )
        if near is not None:
            self._found.ravel()[:], self._prices.ravel()[:] = near
        else:
            self._run()
            # A dual method's answer keeps the rows only when it is the solution.
            rows = self._found.ravel() @ self._matrix
            if not max((low - rows).max(), (rows - high).max()) < 10.0 * _FEASIBLE:
                return None
        return feet.fixed + (feet.basis @ self._found[..., None])[..., 0]

    def _set_cost(self, problem: HorizonProblem, linear: Linearised, feet: FootConstraints) -> None:
        """Gauss-Newton Hessian and gradient at the states + fixed."""
        aim, fixed, basis = problem.aim, feet.fixed, feet.basis
        states = linear.states + fixed
        turned = self._difference[:, None, :, None] * basis.swapaxes(0, 1)
        turned = turned.reshape(states.size, -1)
        pursued = aim.weights > 0.0
        weights = 2.0 * aim.weights[pursued]
        slope = linear.tasks[:, pursued]
        away = (linear.values.tasks - aim.targets)[:, pursued] + (slope @ fixed[..., None])[..., 0]
        slope = slope @ basis
        np.matmul(turned.T, (2.0 * self._weight) * turned, out=self._hessian)
        self._blocks += slope.swapaxes(1, 2) @ (weights[:, None] * slope)
        changes = _changes(problem, states)
        self._gradient[:] = (2.0 * self._weight) * (turned.T @ changes.ravel())
        self._gradient += ((weights * away)[:, None] @ slope).ravel()

    def _add(self, curvature: FloatArray, feet: FootConstraints) -> None:
        """Curvature as it is; without what is negative where the program were not convex."""
        turned = feet.basis.swapaxes(1, 2)
        blocks = turned @ curvature @ feet.basis
        self._gradient += (turned @ (curvature @ feet.fixed[..., None])).ravel()
        self._blocks += blocks
        try:
            np.linalg.cholesky(self._hessian)
        except np.linalg.LinAlgError:
            values, vectors = np.linalg.eigh(blocks)
            negative = np.minimum(values, 0.0)[:, None]
            self._blocks -= (vectors * negative) @ vectors.swapaxes(1, 2)

    def multipliers(
        self, problem: HorizonProblem, inequalities: Inequalities, step: NewtonStep
    ) -> FloatArray:
        """(N, 11) of the CoP (of the edges that bound it), other tasks (zero), foot transform.

        Those of the feet are what they have to bear of the Lagrangian's gradient after a step.
        """
        linear, change, prices, aim = step.linear, step.change, step.prices, problem.aim
        size, edges = change.shape[1], inequalities.scene.normals.shape[1]
        tasks = np.zeros_like(linear.values.tasks)
        tasks[:, :2] = (prices[:, None, :edges] @ inequalities.scene.normals)[:, 0]
        reached = linear.values.tasks + (linear.tasks @ change[..., None])[..., 0]
        pulls = tasks + 2.0 * aim.weights * (reached - aim.targets)
        changes = _changes(problem, linear.states + change)
        gradient = 2.0 * self._weight * self._difference.T @ changes
        gradient += (pulls[:, None] @ linear.tasks)[:, 0]
        gradient += (prices[:, None, edges : -2 * size] @ linear.rest)[:, 0]
        gradient += prices[:, -2 * size : -size] + prices[:, -size:]
        gradient[:-1] -= prices[1:, -size:]
        return np.hstack([tasks, step.feet.borne(gradient)])

    def _set_rows(
        self, linear: Linearised, inequalities: Inequalities, feet: FootConstraints
    ) -> None:
        fixed, basis = feet.fixed, feet.basis
        size = fixed.shape[1]
        values = inequalities.values(linear)
        edges = inequalities.scene.normals @ linear.tasks[:, :2]
        local = np.concatenate([edges, linear.rest], axis=1)
        self._own[..., : -2 * size] = (local @ basis).swapaxes(1, 2)
        turned = basis.swapaxes(1, 2)
        self._own[..., -2 * size : -size] = self._own[..., -size:] = turned
        self._before[...] = -turned[:-1]
        values[:, : -2 * size] += (local @ fixed[..., None])[..., 0]
        values[:, -2 * size : -size] += fixed
        values[:, -size:] += fixed
        values[1:, -size:] -= fixed[:-1]
        np.subtract(inequalities.low, values, out=self._low)
        np.subtract(inequalities.high, values, out=self._high)


def _changes(problem: HorizonProblem, states: FloatArray) -> FloatArray:
    """(N, k) u[i] - u[i-1]."""
    before = [problem.start - problem.previous, problem.start]
    return np.diff(np.vstack([*before, states]), 2, axis=0)
