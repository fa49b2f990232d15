from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.planning.bodies import Body, load_body
from core.planning.motions import SETTINGS, SUPPORTS, motion_of, planner_of
from shoecal_core.planning.collocation import Aim, Collocation, HorizonProblem, Scene
from shoecal_core.planning.ipopt import IpoptSolver
from shoecal_core.planning.landmarks import Contour, sensing_hull
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.sqp import SqpSolver


@pytest.fixture(scope="module")
def collocation(body: Body) -> Collocation:
    return Collocation(body.legs, SETTINGS)


def problems(body: Body) -> list[tuple[HorizonProblem, np.ndarray]]:
    """From several places on the way of a planned motion, with the way on as the guess."""
    found = []
    for index, support in enumerate(SUPPORTS):
        robot, path = body.robot, motion_of(body.robot.name, index).path
        hull = sensing_hull(robot, support)
        scene = Scene.of(hull, SETTINGS.stability_margin, FootPose.of(support), robot.posture)
        for step in (7, len(path.states) // 2):
            start, previous = path.states[step], path.states[step] - path.states[step - 1]
            target = Contour.of(robot, support).corners[step % 4]
            problem = HorizonProblem(start, previous, Aim.at(target, SETTINGS), scene)
            found.append((problem, np.tile(start, (SETTINGS.horizon, 1))))
    return found


def test_agrees_with_interior_points(body: Body, collocation: Collocation) -> None:
    fast, reference = SqpSolver(collocation), IpoptSolver(collocation)
    solved = 0
    for problem, guess in problems(body):
        quick = fast.solve(problem, guess)
        if not quick.converged:
            continue
        solved += 1
        sure = reference.solve(problem, guess)
        assert sure.converged
        assert quick.violation < SETTINGS.tolerance
        assert quick.cost == pytest.approx(sure.cost, rel=1e-3)
        np.testing.assert_allclose(quick.states[:2], sure.states[:2], atol=5e-3)
    assert solved >= 5


def test_an_impossible_problem_is_not_called_solved(body: Body, collocation: Collocation) -> None:
    """Feet a hand's breadth away from where they are cannot be had in these steps."""
    problem, guess = problems(body)[0]
    away = problem.scene.foot_poses + 0.5 * (np.arange(12) == 9)
    impossible = dataclasses.replace(
        problem, scene=dataclasses.replace(problem.scene, foot_poses=away)
    )
    solution = SqpSolver(collocation).solve(impossible, guess)
    assert not solution.converged
    assert solution.violation > 0.1


def test_the_reference_alone_gives_as_good_a_motion() -> None:
    name = "odd_biped"
    body = load_body(name)
    reference = dataclasses.replace(SETTINGS, solver="ipopt")
    motion = type(planner_of(name))(body.robot, reference).plan(SUPPORTS[0])
    assert set(motion.path.statuses) == {"Solve_Succeeded"}
    assert "Solved" in motion_of(name).path.statuses
    reached = motion.path.nearest < SETTINGS.landmark_radius
    np.testing.assert_array_equal(reached, motion_of(name).path.nearest < SETTINGS.landmark_radius)
