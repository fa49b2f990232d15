"""The quadratic programme of one step, in the directions that the feet leave free.

The foot transform leaves each state few of them (5 of 11 for a robot with a shared hip motor).
So the programme is small and dense: 50 unknowns for ten states.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.collocation import FOOT_ROWS, HorizonProblem
from shoecal_core.planning.linearisation import Inequalities, Linearised

FloatArray = NDArray[np.float64]

_FEASIBLE = 1e-9
"""Largest violation of a row by a programme's solution."""


@dataclass(frozen=True)
class Step:
    """What a programme proposes.

    Attributes:
        change: (N, k) of the states [rad].
        gain: how much less the cost is after it, to second order.
        prices: (N, r) multipliers of the inequalities.
    """

    change: FloatArray
    gain: float
    prices: FloatArray


class Programme:
    """Solves programmes of one shape, one after another: memory is used again."""

    def __init__(self, count: int, size: int, rows: int, transition_weight: float) -> None:
        """Take shapes.

        Args:
            count: N states.
            size: k angles each.
            rows: r inequalities each, transitions as the last k.
            transition_weight: Q_u.
        """
        self._weight = transition_weight
        free = size - FOOT_ROWS
        # u[i] - u[i-1] = (difference @ q)[i] + what start and previous transition add.
        ones = np.ones(count)
        self._difference = np.diag(ones) - 2.0 * np.diag(ones[1:], -1) + np.diag(ones[2:], -2)
        unknowns = count * free
        self._hessian, self._gradient = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
        # CasADi stores by columns: rows of this matrix belong to unknowns.
        matrix = np.zeros((count, free, count, rows))
        self._matrix = matrix.reshape(unknowns, -1)
        self._low, self._high = np.zeros((count, rows)), np.zeros((count, rows))
        # Rows of a state depend on it alone, transitions on the state before as well.
        self._own = np.einsum("iaib->iab", matrix)
        self._before = np.einsum("iaib->iab", matrix[:-1, :, 1:])[..., -size:]
        self._found, self._prices = np.zeros((count, free)), np.zeros((count, rows))
        self._solver = ca.conic(
            "programme",
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
        self, problem: HorizonProblem, linear: Linearised, inequalities: Inequalities
    ) -> Step | None:
        """The step from states that `linear` describes; None where the programme has none."""
        fixed, basis = _feet(linear)
        self._set_cost(problem, linear, fixed, basis)
        return self._solved(linear, inequalities, fixed, basis)

    def nearest(self, linear: Linearised, inequalities: Inequalities) -> Step | None:
        """The shortest step that keeps everything to first order; None where there is none."""
        fixed, basis = _feet(linear)
        np.fill_diagonal(self._hessian, 1.0)
        return self._solved(linear, inequalities, fixed, basis)

    def _solved(
        self,
        linear: Linearised,
        inequalities: Inequalities,
        fixed: FloatArray,
        basis: FloatArray,
    ) -> Step | None:
        self._set_rows(linear, inequalities, fixed, basis)
        self._run()
        found = self._found.ravel()
        # A dual method's answer keeps the rows only when it is the solution.
        rows = found @ self._matrix
        missed = max((self._low.ravel() - rows).max(), (rows - self._high.ravel()).max())
        if not missed < 10.0 * _FEASIBLE:
            return None
        change = fixed + (basis @ self._found[..., None])[..., 0]
        gain = -found @ (self._gradient + 0.5 * self._hessian @ found)
        return Step(change, float(gain), self._prices.copy())

    def _set_cost(
        self, problem: HorizonProblem, linear: Linearised, fixed: FloatArray, basis: FloatArray
    ) -> None:
        """Gauss-Newton Hessian and gradient at the states + fixed."""
        aim, count = problem.aim, len(fixed)
        states = linear.states + fixed
        moves = np.diff(
            np.vstack([problem.start - problem.previous, problem.start, states]), axis=0
        )
        turned = self._difference[:, None, :, None] * basis.swapaxes(0, 1)
        turned = turned.reshape(states.size, -1)
        pursued = aim.weights > 0.0
        weights = 2.0 * aim.weights[pursued]
        slope = linear.tasks[:, pursued]
        away = (linear.values.tasks - aim.targets)[:, pursued] + (slope @ fixed[..., None])[..., 0]
        slope = slope @ basis
        np.matmul(turned.T, (2.0 * self._weight) * turned, out=self._hessian)
        blocks = self._hessian.reshape(count, basis.shape[2], count, basis.shape[2])
        np.einsum("iaib->iab", blocks)[...] += slope.swapaxes(1, 2) @ (weights[:, None] * slope)
        self._gradient[:] = (2.0 * self._weight) * (turned.T @ np.diff(moves, axis=0).ravel())
        self._gradient += ((weights * away)[:, None] @ slope).ravel()

    def _set_rows(
        self,
        linear: Linearised,
        inequalities: Inequalities,
        fixed: FloatArray,
        basis: FloatArray,
    ) -> None:
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


def _feet(linear: Linearised) -> tuple[FloatArray, FloatArray]:
    """(N, k), (N, k, f): a step is fixed + basis @ free, which puts the feet right."""
    factor, triangle = np.linalg.qr(linear.foot.swapaxes(1, 2), mode="complete")
    error = linear.values.foot_error[..., None]
    inner = np.linalg.solve(triangle[:, :FOOT_ROWS].swapaxes(1, 2), -error)
    return (factor[:, :, :FOOT_ROWS] @ inner)[..., 0], factor[:, :, FOOT_ROWS:]
