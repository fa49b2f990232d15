"""The fast solver: sequential quadratic programmes with Gauss-Newton second derivatives.

The foot transform leaves each state few free directions (5 of 11 for a robot with a shared hip
motor). Every programme is solved in those: small, dense, and with an active set that hardly
changes from one to the next. Where this solver fails, another has to step in.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.collocation import (
    TASKS,
    Collocation,
    HorizonProblem,
    Limits,
    Solution,
)

FloatArray = NDArray[np.float64]

_ITERATIONS = 12
"""More are not worth it: interior points are surer then."""
_STEP = 1e-3
"""rad; after a step this small, what is left of the curvature is far below the tolerance."""
_SHORTENINGS = 4
_FOOT_ROWS = 6


@dataclass(frozen=True)
class _Linear:
    """All constraints of N states and their derivatives.

    Attributes:
        tasks, task_slope: (N, 5), (N, 5, k).
        foot, foot_slope: (N, 6), (N, 6, k).
        values, slopes: (N, r), (N, r, k) of capsule distances and torques.
    """

    tasks: FloatArray
    task_slope: FloatArray
    foot: FloatArray
    foot_slope: FloatArray
    values: FloatArray
    slopes: FloatArray


class SqpSolver:
    """Solves a horizon's problem from a near guess in a few small quadratic programmes."""

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        robot = collocation.legs.robot
        self._count, self._size = collocation.settings.horizon, len(robot.legs)
        angles, pose = ca.SX.sym("q", self._size), ca.SX.sym("foot_pose", 12)
        others, share = ca.SX.sym("others", len(robot.joint_names)), ca.SX.sym("share", 2)
        rows = ca.vertcat(*collocation.state(angles, pose, others, share))
        slopes = ca.densify(ca.jacobian(rows, angles))
        self._rows = int(rows.numel())
        self._linear = ca.Function(
            "linear", [angles, pose, others, share], [rows, slopes], {"cse": True}
        ).map(self._count)
        # u[i] - u[i-1] = (difference @ q)[i] + what start and previous transition add.
        ones = np.ones(self._count)
        self._difference = np.diag(ones) - 2.0 * np.diag(ones[1:], -1) + np.diag(ones[2:], -2)
        self._edges = collocation.edges
        pattern = self._pattern()
        # CasADi stores by columns.
        self._columns, self._lines = np.nonzero(pattern.T)
        self._sparsity = ca.Sparsity.triplet(
            pattern.shape[0], pattern.shape[1], self._lines.tolist(), self._columns.tolist()
        )
        free = pattern.shape[1]
        self._programme = ca.conic(
            "programme",
            "daqp",
            {"h": ca.Sparsity.dense(free, free), "a": self._sparsity},
            {"error_on_fail": False},
        )

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """See Solver."""
        collocation = self._collocation
        problem = dataclasses.replace(problem, scene=problem.scene.padded(self._edges))
        limits = collocation.limits(problem)
        states = np.clip(guess, limits.lower, limits.upper)
        penalty = self._penalty(problem, states)

        def merit_of(tried: FloatArray) -> float:
            cost, violation = collocation.assess(problem, limits, tried)
            return cost + penalty * violation

        merit = merit_of(states)
        for iteration in range(1, _ITERATIONS + 1):
            step = self._step(problem, limits, states)
            if step is None:
                return collocation.certified(problem, states, "Programme_Failed", iteration, False)
            for shortening in range(_SHORTENINGS):
                tried = states + step / 2.0**shortening
                merit_tried = merit_of(tried)
                if merit_tried < merit:
                    break
            done = float(np.abs(step).max()) < _STEP
            if merit_tried < merit:
                states, merit = tried, merit_tried
            elif not done:
                return collocation.certified(problem, states, "Step_Rejected", iteration, False)
            if done:
                return collocation.certified(problem, states, "Solved", iteration, True)
        return collocation.certified(problem, states, "Iterations_Exceeded", _ITERATIONS, False)

    def _pattern(self) -> FloatArray:
        """Where the rows of _inequalities may differ from zero: in a state's own free directions,
        and for the transitions in those of the state before as well.
        """
        count, free = self._count, self._size - _FOOT_ROWS
        local = self._edges + self._rows - TASKS - _FOOT_ROWS + self._size
        pattern = np.zeros((count, local + self._size, count, free))
        for index in range(count):
            pattern[index, :, index] = 1.0
            pattern[index, local:, max(index - 1, 0)] = 1.0
        return pattern.reshape(count * (local + self._size), count * free)

    def _penalty(self, problem: HorizonProblem, states: FloatArray) -> float:
        """Weight of violations in the merit: well above what they could buy in cost."""
        aim = problem.aim
        away = self._collocation.evaluate(states, problem.scene).tasks - aim.targets
        pull = np.max(aim.weights * (np.abs(away).max(axis=0) + 0.01))
        return float(20.0 * self._count * pull)

    def _linearised(self, problem: HorizonProblem, states: FloatArray) -> _Linear:
        scene = problem.scene
        rows, slopes = self._linear(
            states.T,
            *(
                np.broadcast_to(given, (self._count, given.shape[-1])).T
                for given in (scene.foot_poses, scene.others, scene.shares)
            ),
        )
        value = np.array(rows).T
        slope = np.array(slopes).reshape(self._rows, self._count, self._size).swapaxes(0, 1)
        foot = slice(TASKS, TASKS + _FOOT_ROWS)
        rest = slice(TASKS + _FOOT_ROWS, None)
        return _Linear(
            value[:, :TASKS], slope[:, :TASKS], value[:, foot], slope[:, foot], value[:, rest],
            slope[:, rest],
        )  # fmt: skip

    def _step(
        self, problem: HorizonProblem, limits: Limits, states: FloatArray
    ) -> FloatArray | None:
        """(N, k) change of the states by one quadratic programme; None where it has none."""
        linear = self._linearised(problem, states)
        # step = fixed + basis @ free: the feet are put right whatever the free part is.
        factor, triangle = np.linalg.qr(linear.foot_slope.swapaxes(1, 2), mode="complete")
        basis = factor[:, :, _FOOT_ROWS:]
        inner = np.linalg.solve(triangle[:, :_FOOT_ROWS].swapaxes(1, 2), -linear.foot[..., None])
        fixed = (factor[:, :, :_FOOT_ROWS] @ inner)[..., 0]
        hessian, gradient = self._quadratic(problem, linear, states + fixed, fixed, basis)
        matrix, low, high = self._inequalities(problem, limits, linear, states, fixed, basis)
        entries = ca.DM(self._sparsity, matrix[self._lines, self._columns])
        result = self._programme(h=hessian, g=gradient, a=entries, lba=low, uba=high)
        if not self._programme.stats()["success"]:
            return None
        free = np.array(result["x"]).reshape(self._count, -1)
        step: FloatArray = fixed + (basis @ free[..., None])[..., 0]
        return step if np.all(np.isfinite(step)) else None

    def _quadratic(
        self,
        problem: HorizonProblem,
        linear: _Linear,
        states: FloatArray,
        fixed: FloatArray,
        basis: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Hessian and gradient of the cost in the free directions, at `states`."""
        collocation = self._collocation
        weight = collocation.settings.transition_weight
        moves = np.vstack([problem.previous, collocation.transitions(problem, states)])
        aim = problem.aim
        slope = linear.task_slope @ basis
        away = linear.tasks + (linear.task_slope @ fixed[..., None])[..., 0] - aim.targets
        coupling = self._difference.T @ self._difference
        free = basis.shape[2]
        hessian = 2.0 * weight * np.einsum("nka,nm,mkb->namb", basis, coupling, basis)
        pull = slope.swapaxes(1, 2) @ (2.0 * aim.weights[:, None] * slope)
        for index in range(self._count):
            hessian[index, :, index] += pull[index]
        change = 2.0 * weight * self._difference.T @ np.diff(moves, axis=0)
        gradient = np.einsum("nka,nk->na", basis, change)
        gradient += np.einsum("nca,nc->na", slope, 2.0 * aim.weights * away)
        size = self._count * free
        return hessian.reshape(size, size), gradient.ravel()

    def _inequalities(
        self,
        problem: HorizonProblem,
        limits: Limits,
        linear: _Linear,
        states: FloatArray,
        fixed: FloatArray,
        basis: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rows of the programme and their bounds: edges, distances, torques, limits, moves."""
        scene = problem.scene
        count, size, free = self._count, self._size, basis.shape[2]
        pairs = limits.clearances.shape[1]
        endless = np.full((count, self._edges), np.inf)
        edges = scene.normals @ linear.task_slope[:, :2]
        beyond = limits.offsets - scene.beyond(linear.tasks[:, :2])
        torque = linear.values[:, pairs:]
        slopes = np.concatenate(
            [edges, linear.slopes, np.broadcast_to(np.eye(size), (count, size, size))], axis=1
        )
        low = np.hstack(
            [-endless, limits.clearances - linear.values[:, :pairs], -limits.torque - torque,
             limits.lower - states]
        )  # fmt: skip
        high = np.hstack(
            [beyond, np.full((count, pairs), np.inf), limits.torque - torque,
             limits.upper - states]
        )  # fmt: skip
        already = (slopes @ fixed[..., None])[..., 0]
        rows = slopes.shape[1]
        matrix = np.zeros((count, rows + size, count, free))
        local = slopes @ basis
        for index in range(count):
            matrix[index, :rows, index] = local[index]
            matrix[index, rows:, index] = basis[index]
            if index:
                matrix[index, rows:, index - 1] = -basis[index - 1]
        moves = self._collocation.transitions(problem, states + fixed)
        low = np.hstack([low - already, -limits.transition - moves])
        high = np.hstack([high - already, limits.transition - moves])
        return matrix.reshape(count * (rows + size), -1), low.ravel(), high.ravel()
