"""The reference solver: interior points with exact second derivatives."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TypeVar

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.problem import TASKS, HorizonProblem, HorizonSolution
from shoecal_core.planning.settings import PlannerSettings

Expression = TypeVar("Expression", ca.SX, ca.MX)

_OPTIONS: dict[str, bool | int | float | str] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.linear_solver": "mumps",
    "ipopt.tol": 1e-6,
    "ipopt.constr_viol_tol": 1e-8,
    "ipopt.mu_init": 1e-3,
}


def horizon_nlp(collocation: Collocation, symbols: type[Expression]) -> dict[str, Expression]:
    """The whole problem over one horizon, as CasADi's nlpsol takes it.

    Args:
        collocation: the functions of one state.
        symbols: kind of the expressions; scalars (SX), or matrices that call those functions (MX).
    """
    settings, edges = collocation.settings, collocation.edges
    count, size = settings.horizon, len(collocation.lower)
    states = symbols.sym("q", size, count)
    start, previous = symbols.sym("start", size), symbols.sym("previous", size)
    targets, weights = symbols.sym("targets", TASKS, count), symbols.sym("weights", TASKS)
    # Columns: normals' x, then y.
    normals = symbols.sym("normals", 2 * edges, count)
    foot_poses, shares = symbols.sym("foot_poses", 12, count), symbols.sym("shares", 2, count)
    others = symbols.sym("others", len(collocation.legs.robot.joint_names))
    cost, constraints = symbols(0), []
    before, moved = start, previous
    for index in range(count):
        now = states[:, index]
        tasks, error, distances, balance, torques = collocation.state(
            now, foot_poses[:, index], others, shares[:, index]
        )
        move = now - before
        cost += ca.dot(weights, (tasks - targets[:, index]) ** 2)
        cost += settings.transition_weight * ca.sumsqr(move - moved)
        beyond = ca.reshape(normals[:, index], edges, 2) @ tasks[:2]
        constraints += [error, beyond, distances, balance, torques, move]
        before, moved = now, move
    parameters = ca.veccat(start, previous, targets, weights, normals, foot_poses, shares, others)
    return {"x": ca.vec(states), "p": parameters, "f": cost, "g": ca.vertcat(*constraints)}


def ipopt_options(settings: PlannerSettings) -> dict[str, bool | int | float | str]:
    """Options of CasADi's nlpsol."""
    return _OPTIONS | {"ipopt.max_iter": settings.iterations}


class IpoptSolver:
    """Solves the whole problem at once; one for every step and support.

    The problem is written out when it is first asked for: that takes seconds, and where the fast
    solver converges nothing asks.
    """

    def __init__(self, collocation: Collocation, solver: ca.Function | None = None) -> None:
        """Take the functions of one state.

        Args:
            collocation: these functions.
            solver: made by nlpsol from `horizon_nlp` in another way, if it shall be.
        """
        self._collocation = collocation
        self._edges = collocation.edges
        self._given = solver

    @cached_property
    def _solver(self) -> ca.Function:
        if self._given is not None:
            return self._given
        problem = horizon_nlp(self._collocation, ca.SX)
        return ca.nlpsol("horizon", "ipopt", problem, ipopt_options(self._collocation.settings))

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        """States (N, k) from a guess of them (N, k) [rad]; see Solver."""
        scene, aim = problem.scene.padded(self._edges), problem.aim
        problem = dataclasses.replace(problem, scene=scene)
        limits = self._collocation.limits(problem)
        count = len(limits.lower)
        offsets = limits.offsets
        zero, free = np.zeros((count, 6)), np.full_like(limits.clearances, np.inf)
        both = np.tile(np.concatenate([limits.torque, limits.transition]), (count, 1))
        any_load = np.full_like(limits.balance, np.inf)
        low = [zero, np.full_like(offsets, -np.inf), limits.clearances, limits.balance, -both]
        high = [zero, offsets, free, any_load, both]
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
