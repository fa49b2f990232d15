from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner_cases import Case, with_horizon
from planner_references import compiled_ipopt, judge, mx_ipopt
from shoecal_core.compiler import CompilerError, find_compiler
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.problem import Aim, HorizonProblem, Scene, Solver
from shoecal_core.planning.horizon.sqp import SqpSolver
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.posture import StanceSolver
from shoecal_core.planning.settings import PlannerSettings

SETTINGS = with_horizon(PlannerSettings(), 2)
SUPPORT = DoubleSupport(0.02, -0.12, -0.2)


@pytest.fixture(scope="module")
def collocation() -> Collocation:
    return Case.named("nao").collocation(SETTINGS)


@pytest.fixture(scope="module")
def problem(collocation: Collocation) -> HorizonProblem:
    """From a stance towards a place 2 cm ahead."""
    legs = collocation.legs
    start = StanceSolver(legs, SETTINGS).solve(SUPPORT)
    hull = sensing_hull(legs.robot, SUPPORT)
    scene = Scene.of(
        hull, SETTINGS.stability_margin, FootPose.of(SUPPORT), legs.robot.from_legs(start)
    )
    ahead = collocation.evaluate(start[None], scene).cop[0] + [0.02, 0.0]
    return HorizonProblem(start, np.zeros_like(start), Aim.at(ahead, SETTINGS), scene)


def test_all_ways_to_solve_a_problem_find_one_optimum(
    collocation: Collocation, problem: HorizonProblem, tmp_path: Path
) -> None:
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))
    solvers: list[Solver] = [
        judge(collocation),
        IpoptSolver(collocation),
        mx_ipopt(collocation),
        compiled_ipopt(collocation, tmp_path, ["-O0"]),
        SqpSolver(collocation),
    ]
    guess = np.tile(problem.start, (SETTINGS.horizon, 1))
    best, *others = (solver.solve(problem, guess) for solver in solvers)
    assert best.converged
    for solution in others:
        assert solution.converged
        assert solution.cost == pytest.approx(best.cost, rel=1e-6)
        np.testing.assert_allclose(solution.states, best.states, atol=1e-5)
