"""Solves horizons with crocoddyl; runs in a virtual environment that has it, and nothing of ours.

Reads a line of JSON that says what a state's function is called and where its library lies, says
that it is ready, then reads one line a problem and answers each: states, seconds, iterations.

The state of the shooting problem is (q, u) of the step before, the control is u, so that the state
equation and the cost of equation 9 are exact, and |u| is bounded by the solver itself (a box).
The solver used knows no other constraints: polygon, distances, torques and joint limits are
quadratic penalties, as crocoddyl's examples have them, and so is the foot transform.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import casadi as ca
import crocoddyl
import numpy as np

ITERATIONS = 100


class Stage:
    """Values and slopes of one state, from a compiled function without copies."""

    def __init__(self, name: str, library: str, rows: int, size: int) -> None:
        self._function = ca.external(name, library)
        inputs = self._function.size1_in(0)
        self.input, self._found = np.zeros(inputs), np.zeros(rows * (1 + size))
        buffer: Any
        buffer, self._run = self._function.buffer()
        buffer.set_arg(0, self.input.data)
        buffer.set_res(0, self._found.data)
        self._buffer = buffer
        self.values = self._found[:rows]
        self.slopes = self._found[rows:].reshape(rows, size)

    def __call__(self, angles: Any) -> None:
        self.input[: len(angles)] = angles
        self._run()


class Step(crocoddyl.ActionModelAbstract):  # type: ignore[misc]  # it has no types
    """From q[i-1] and u[i-2] by u[i-1] to q[i]: the cost of that state and all it has to keep."""

    def __init__(self, stage: Stage, size: int, setup: dict[str, Any]) -> None:
        super().__init__(crocoddyl.StateVector(2 * size), size, 0)
        self._stage, self._size, self._setup = stage, size, setup
        self._last = np.full(2 * size + size, np.nan)
        self._residual = np.zeros(0)
        self._jacobian = np.zeros((0, size))

    def pose(self, given: dict[str, Any], index: int) -> None:
        """Take one state of a problem."""
        self._parameters = np.concatenate(
            [given["foot_poses"][index], given["others"], given["shares"][index]]
        )
        self._targets, self._weights = given["targets"][index], given["weights"]
        self._normals, self._offsets = given["normals"][index], given["offsets"][index]
        self._clearances = given["clearances"][index]
        self._lower, self._upper = given["lower"][index], given["upper"][index]
        self._torque = given["torque"]
        self.u_lb, self.u_ub = -given["transition"], given["transition"]
        self._last[:] = np.nan

    def calc(self, data: Any, x: Any, u: Any = None) -> None:
        size = self._size
        if u is None:
            data.xnext, data.cost = x, 0.0
            return
        moved = x[:size] + u
        data.xnext = np.concatenate([moved, u])
        self._evaluate(x, u)
        change = u - x[size:]
        data.cost = float(self._residual @ self._residual)
        data.cost += self._setup["transition_weight"] * float(change @ change)

    def calcDiff(self, data: Any, x: Any, u: Any = None) -> None:
        size, weight = self._size, 2.0 * self._setup["transition_weight"]
        if u is None:
            return
        self._evaluate(x, u)
        gradient = 2.0 * self._jacobian.T @ self._residual
        curvature = 2.0 * self._jacobian.T @ self._jacobian
        pull = weight * (u - x[size:])
        one = np.eye(size)
        zero = np.zeros((size, size))
        data.Fx = np.block([[one, zero], [zero, zero]])
        data.Fu = np.vstack([one, one])
        data.Lx = np.concatenate([gradient, -pull])
        data.Lu = gradient + pull
        data.Lxx = np.block([[curvature, zero], [zero, weight * one]])
        data.Lxu = np.vstack([curvature, -weight * one])
        data.Luu = curvature + weight * one

    def _evaluate(self, x: Any, u: Any) -> None:
        """Residuals whose squares are the cost of the state, penalties among them."""
        here = np.concatenate([x, u])
        if np.array_equal(here, self._last):
            return
        self._last[:] = here
        size, stage, setup = self._size, self._stage, self._setup
        angles = x[:size] + u
        stage.input[size:] = self._parameters
        stage(angles)
        tasks, foot = setup["tasks"], setup["tasks"] + setup["foot_rows"]
        values, slopes = stage.values, stage.slopes
        pull = np.sqrt(self._weights)
        hard, torque_weight = setup["penalty"], setup["torque_penalty"]
        pairs = len(self._clearances)
        torques = values[foot + pairs :]
        turns = slopes[foot + pairs :]
        parts = [
            (pull * (values[:tasks] - self._targets), pull[:, None] * slopes[:tasks]),
            (hard * values[tasks:foot], hard * slopes[tasks:foot]),
            beyond(
                hard, self._normals @ values[:2] - self._offsets, self._normals @ slopes[:2]
            ),
            beyond(
                hard, self._clearances - values[foot : foot + pairs],
                -slopes[foot : foot + pairs],
            ),
            beyond(torque_weight, torques - self._torque, turns),
            beyond(torque_weight, -torques - self._torque, -turns),
            beyond(hard, angles - self._upper, np.eye(size)),
            beyond(hard, self._lower - angles, -np.eye(size)),
        ]  # fmt: skip
        self._residual = np.concatenate([part[0] for part in parts])
        self._jacobian = np.vstack([part[1] for part in parts])


def beyond(weight: float, excess: Any, slopes: Any) -> tuple[Any, Any]:
    """Residual of a penalty: only what is beyond its bound counts."""
    active = excess > 0.0
    return weight * excess[active], weight * slopes[active]


class Worker:
    """Models are built once and take one problem after another."""

    def __init__(self, setup: dict[str, Any]) -> None:
        self._size, count = setup["size"], setup["count"]
        stage = Stage(setup["name"], setup["library"], setup["rows"], self._size)
        self._steps = [Step(stage, self._size, setup) for _ in range(count)]
        self._end = Step(stage, self._size, setup)
        self._solver = getattr(crocoddyl, setup["solver"])

    def solve(self, given: dict[str, Any]) -> dict[str, Any]:
        """One problem."""
        given = {key: np.array(value, dtype=np.float64) for key, value in given.items()}
        wall, cpu = time.perf_counter(), time.process_time()
        for index, step in enumerate(self._steps):
            step.pose(given, index)
        start = np.concatenate([given["start"], given["previous"]])
        problem = crocoddyl.ShootingProblem(start, self._steps, self._end)
        solver = self._solver(problem)
        moves = np.diff(np.vstack([given["start"], given["guess"]]), axis=0)
        guess = [start, *map(np.concatenate, zip(given["guess"], moves, strict=True))]
        done = solver.solve(guess, list(moves), ITERATIONS, False)
        states = np.array([x[: self._size] for x in list(solver.xs)[1:]])
        return {
            "wall": time.perf_counter() - wall,
            "cpu": time.process_time() - cpu,
            "states": states.tolist(),
            "iterations": int(solver.iter),
            "converged": bool(done),
        }


def main() -> None:
    """Serve until the input ends."""
    worker = Worker(json.loads(sys.stdin.readline()))
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        print(json.dumps(worker.solve(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
