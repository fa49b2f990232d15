"""The reference solver: interior points with exact second derivatives."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.collocation import Collocation, HorizonProblem, Solution

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
        # A convex hull has no more edges than the polygons it is made of have corners.
        self._edges = sum(len(foot.sensing_polygon) for foot in collocation.legs.robot.feet)
        states = ca.SX.sym("q", size, count)
        start, previous = ca.SX.sym("start", size), ca.SX.sym("previous", size)
        target, normals = ca.SX.sym("target", 2), ca.SX.sym("normals", self._edges, 2)
        foot_pose, others = (
            ca.SX.sym("foot_pose", 12),
            ca.SX.sym("others", len(collocation.legs.robot.joint_names)),
        )
        weights = ca.DM(collocation.cop_weights)
        cost, constraints = ca.SX(0), []
        before, moved = start, previous
        for index in range(count):
            now = states[:, index]
            cop, error, distances, torques = collocation.state(now, foot_pose, others)
            move = now - before
            cost += ca.dot(weights, (cop - target) ** 2)
            cost += settings.transition_weight * ca.sumsqr(move - moved)
            constraints += [error, normals @ cop, distances, torques, move]
            before, moved = now, move
        parameters = ca.vertcat(start, previous, target, ca.vec(normals), foot_pose, others)
        problem = {
            "x": ca.vec(states), "p": parameters, "f": cost, "g": ca.vertcat(*constraints),
        }  # fmt: skip
        options = {**_OPTIONS, "ipopt.max_iter": settings.iterations}
        self._solver = ca.nlpsol("horizon", "ipopt", problem, options)

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> Solution:
        """See Solver."""
        scene = problem.scene
        limits = self._collocation.limits(problem)
        count = len(limits.lower)
        # Edges that the polygon lacks: 0 * c <= inf.
        missing = self._edges - len(scene.offsets)
        normals = np.vstack([scene.normals, np.zeros((missing, 2))])
        offsets = np.hstack([limits.offsets, np.full((count, missing), np.inf)])
        zero, free = np.zeros((count, 6)), np.full_like(limits.clearances, np.inf)
        both = np.tile(np.concatenate([limits.torque, limits.transition]), (count, 1))
        low = [zero, np.full_like(offsets, -np.inf), limits.clearances, -both]
        high = [zero, offsets, free, both]
        parameters = [
            problem.start, problem.previous, problem.target, normals.T.ravel(),
            scene.foot_pose.parameters, scene.others,
        ]  # fmt: skip
        result = self._solver(
            x0=np.clip(guess, limits.lower, limits.upper).ravel(),
            p=np.concatenate(parameters),
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
