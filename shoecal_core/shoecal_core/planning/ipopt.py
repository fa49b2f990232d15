"""The reference solver: interior points with exact second derivatives."""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.collocation import TASKS, Collocation, HorizonProblem, Solution

FloatArray = NDArray[np.float64]

_OPTIONS: dict[str, bool | int | float | str] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.linear_solver": "mumps",
    "ipopt.tol": 1e-6,
    "ipopt.constr_viol_tol": 1e-8,
    "ipopt.mu_init": 1e-3,
}


class IpoptSolver:
    """Solves the whole problem at once; one compiled object for every step and support."""

    def __init__(self, collocation: Collocation) -> None:
        self._collocation = collocation
        settings = collocation.settings
        count, size = settings.horizon, len(collocation.lower)
        self._edges = collocation.edges
        states = ca.SX.sym("q", size, count)
        start, previous = ca.SX.sym("start", size), ca.SX.sym("previous", size)
        targets, weights = ca.SX.sym("targets", TASKS, count), ca.SX.sym("weights", TASKS)
        # Columns: normals' x, then y.
        normals = ca.SX.sym("normals", 2 * self._edges, count)
        foot_poses, shares = ca.SX.sym("foot_poses", 12, count), ca.SX.sym("shares", 2, count)
        others = ca.SX.sym("others", len(collocation.legs.robot.joint_names))
        cost, constraints = ca.SX(0), []
        before, moved = start, previous
        for index in range(count):
            now = states[:, index]
            tasks, error, distances, torques = collocation.state(
                now, foot_poses[:, index], others, shares[:, index]
            )
            move = now - before
            cost += ca.dot(weights, (tasks - targets[:, index]) ** 2)
            cost += settings.transition_weight * ca.sumsqr(move - moved)
            beyond = ca.reshape(normals[:, index], self._edges, 2) @ tasks[:2]
            constraints += [error, beyond, distances, torques, move]
            before, moved = now, move
        parameters = ca.veccat(
            start, previous, targets, weights, normals, foot_poses, shares, others
        )
        problem = {
            "x": ca.vec(states), "p": parameters, "f": cost, "g": ca.vertcat(*constraints),
        }  # fmt: skip
        options = {**_OPTIONS, "ipopt.max_iter": settings.iterations}
        self._solver = ca.nlpsol("horizon", "ipopt", problem, options)

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """See Solver."""
        scene, aim = problem.scene.padded(self._edges), problem.aim
        problem = dataclasses.replace(problem, scene=scene)
        limits = self._collocation.limits(problem)
        count = len(limits.lower)
        offsets = limits.offsets
        zero, free = np.zeros((count, 6)), np.full_like(limits.clearances, np.inf)
        both = np.tile(np.concatenate([limits.torque, limits.transition]), (count, 1))
        low = [zero, np.full_like(offsets, -np.inf), limits.clearances, -both]
        high = [zero, offsets, free, both]
        # CasADi stores by columns, one a state.
        normals = scene.normals.swapaxes(1, 2).reshape(-1, 2 * self._edges)
        rows = [
            np.broadcast_to(values, (count, values.shape[1])).ravel()
            for values in (aim.targets, normals, scene.foot_poses, scene.shares)
        ]
        parameters = [problem.start, problem.previous, rows[0], aim.weights, *rows[1:]]
        result = self._solver(
            x0=np.clip(guess, limits.lower, limits.upper).ravel(),
            p=np.concatenate([*parameters, scene.others]),
            lbx=limits.lower.ravel(),
            ubx=limits.upper.ravel(),
            lbg=np.hstack(low).ravel(),
            ubg=np.hstack(high).ravel(),
        )
        stats = self._solver.stats()
        states = np.array(result["x"]).reshape(count, -1)
        return self._collocation.certified(
            problem,
            np.clip(states, limits.lower, limits.upper),
            str(stats["return_status"]),
            int(stats["iter_count"]),
            bool(stats["success"]),
        )
