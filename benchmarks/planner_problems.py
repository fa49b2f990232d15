"""The optimisations that planning poses in closed loop, and solvers on them in turns."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver, horizon_nlp, ipopt_options
from shoecal_core.planning.horizon.problem import HorizonProblem, HorizonSolution, Solver
from shoecal_core.planning.horizon.rolling import RollingHorizon
from shoecal_core.planning.motion_catalogue import motion_kind
from shoecal_core.planning.planner import Planner

COMPILER = {"flags": ["-O3", "-march=native"], "compiler": "cc"}
_JUDGE: dict[str, bool | int | float | str] = {
    "ipopt.tol": 1e-10,
    "ipopt.dual_inf_tol": 1e-8,
    "ipopt.compl_inf_tol": 1e-10,
    "ipopt.constr_viol_tol": 1e-10,
    "ipopt.bound_relax_factor": 0.0,
    "ipopt.max_iter": 1000,
}


@dataclass(frozen=True)
class Posed:
    """One optimisation, and the states (N, k) that its solver began with [rad]."""

    problem: HorizonProblem
    guess: FloatArray


class Recorder:
    """A solver that remembers what it was asked."""

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self.posed: list[Posed] = []

    def solve(self, problem: HorizonProblem, guess: FloatArray) -> HorizonSolution:
        """See Solver."""
        self.posed.append(Posed(problem, guess))
        return self._solver.solve(problem, guess)


def posed_in_closed_loop(
    planner: Planner, solver: Solver, angles: Sequence[FloatArray]
) -> list[Posed]:
    """All optimisations of one motion over the landmarks from each of the joint angles (m,)."""
    recorder = Recorder(solver)
    horizon = RollingHorizon(planner.horizon.collocation, [recorder])
    for standing in angles:
        (segment,) = motion_kind("landmarks").segments(planner.standing(standing))
        horizon.roll(standing[planner.legs.robot.legs], segment, standing)
    return recorder.posed


def compiled_ipopt(collocation: Collocation) -> IpoptSolver:
    """IPOPT with all functions and their first and second derivatives as machine code.

    By CasADi itself, from matrix expressions: those of scalars are four times as much code and were
    slower when they were tried.
    """
    jit = {"jit": True, "compiler": "shell", "jit_options": COMPILER}
    options: dict[str, Any] = ipopt_options(collocation.settings) | jit
    programme = horizon_nlp(collocation, ca.MX)
    return IpoptSolver(collocation, ca.nlpsol("compiled", "ipopt", programme, options))


def judge(collocation: Collocation) -> IpoptSolver:
    """Tight tolerances and unrelaxed bounds, to tell what the optimum is."""
    options = ipopt_options(collocation.settings) | _JUDGE
    programme = horizon_nlp(collocation, ca.SX)
    return IpoptSolver(collocation, ca.nlpsol("judge", "ipopt", programme, options))


@dataclass(frozen=True)
class Timed:
    """What a solver made of one problem, and the processor's time [s]."""

    solution: HorizonSolution
    seconds: float


def race(solvers: Mapping[str, Solver], posed: Sequence[Posed]) -> dict[str, list[Timed]]:
    """Every problem by all solvers before the next one, each from the same guess.

    Before its time is taken a solver solves the problem before once more (the first one itself):
    so its caches are as warm as in a closed loop, and what it keeps from solve to solve is the
    same.
    """
    found: dict[str, list[Timed]] = {name: [] for name in solvers}
    for before, one in zip([posed[0], *posed], posed, strict=False):
        for name, solver in solvers.items():
            solver.solve(before.problem, before.guess)
            begin = time.process_time()
            solution = solver.solve(one.problem, one.guess)
            found[name].append(Timed(solution, time.process_time() - begin))
    return found
