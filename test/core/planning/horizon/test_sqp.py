"""The fast solver against the reference, the conditions of an optimum, and its own promises."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from core.planning.bodies import Body, load_body
from core.planning.horizons import lifting, problems
from core.planning.motions import SETTINGS, SUPPORTS, motion_of, planner_of
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon import sqp
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.linearisation import Inequalities, Linearisation
from shoecal_core.planning.horizon.problem import HorizonProblem
from shoecal_core.planning.horizon.sqp import SqpSolver


@pytest.fixture(scope="module")
def collocation(body: Body) -> Collocation:
    return Collocation(body.legs, SETTINGS)


@pytest.fixture(scope="module")
def fast(collocation: Collocation) -> SqpSolver:
    return SqpSolver(collocation)


def test_agrees_with_interior_points(body: Body, collocation: Collocation, fast: SqpSolver) -> None:
    """Never worse; better where interior points stay at a saddle.

    Where it does not arrive it says so, and they step in.
    """
    reference, same, arrived = IpoptSolver(collocation), [], []
    for problem, guess in [*problems(body)[::2], lifting(body)]:
        quick, sure = fast.solve(problem, guess), reference.solve(problem, guess)
        assert sure.converged
        arrived.append(quick.converged)
        if not quick.converged:
            continue
        assert quick.violation < 1e-7
        assert quick.cost < (1.0 + 1e-5) * sure.cost
        same.append(quick.cost > (1.0 - 1e-6) * sure.cost)
        if same[-1]:
            np.testing.assert_allclose(quick.states[:2], sure.states[:2], atol=1e-3)
    assert sum(same) >= len(same) - 1
    assert sum(arrived) >= len(arrived) - 1


def stationarity(collocation: Collocation, problem: HorizonProblem, states: FloatArray) -> float:
    """What no prices of what is kept can balance of the cost's slope, as a share of it."""
    problem = dataclasses.replace(problem, scene=problem.scene.padded(collocation.edges))
    inequalities = Inequalities(problem, collocation.limits(problem))
    linear = Linearisation(collocation)(states, problem.scene)
    count, size = states.shape
    away = 2.0 * problem.aim.weights * (linear.values.tasks - problem.aim.targets)
    pull = np.einsum("nt,ntk->nk", away, linear.tasks)
    # u[i] - u[i-1], and its slopes with states.
    before = [problem.start - problem.previous, problem.start]
    change = np.diff(np.vstack([*before, states]), 2, axis=0)
    second = np.diff(np.eye(count + 2), 2, axis=0)[:, 2:]
    gradient = (pull + 2.0 * SETTINGS.transition_weight * second.T @ change).ravel()
    values = inequalities.values(linear)
    edges = inequalities.scene.normals @ linear.tasks[:, :2]
    unit = np.broadcast_to(np.eye(size), (count, size, size))
    local = np.concatenate([edges, linear.rest, unit, unit], axis=1)
    columns, lowest = [], []
    for state in range(count):
        for row in linear.foot[state]:
            columns.append(placed(row, state, count))
            lowest.append(-np.inf)
        for index, row in enumerate(local[state]):
            column = placed(row, state, count)
            if index >= local.shape[1] - size and state:
                column -= placed(row, state - 1, count)
            for sign, room in (
                (1.0, inequalities.high[state, index] - values[state, index]),
                (-1.0, values[state, index] - inequalities.low[state, index]),
            ):
                if room < 1e-6:
                    columns.append(sign * column)
                    lowest.append(0.0)
    found = lsq_linear(np.array(columns).T, -gradient, (lowest, np.inf))
    return float(np.linalg.norm(found.fun) / np.linalg.norm(gradient))


def placed(row: FloatArray, state: int, count: int) -> FloatArray:
    column = np.zeros((count, len(row)))
    column[state] = row
    return column.ravel()


def test_prices_balance_the_cost(body: Body, collocation: Collocation, fast: SqpSolver) -> None:
    """The conditions of Karush, Kuhn and Tucker, written out anew."""
    for problem, guess in [*problems(body)[1::3], lifting(body)]:
        solution = fast.solve(problem, guess)
        assert solution.converged
        assert stationarity(collocation, problem, solution.states) < 1e-3
        assert stationarity(collocation, problem, guess) > 1e-2


def test_an_impossible_problem_is_not_called_solved(body: Body, fast: SqpSolver) -> None:
    """Feet a hand's breadth away from where they are cannot be had in these steps."""
    problem, guess = problems(body)[0]
    away = problem.scene.foot_poses + 0.5 * (np.arange(12) == 9)
    impossible = dataclasses.replace(
        problem, scene=dataclasses.replace(problem.scene, foot_poses=away)
    )
    solution = fast.solve(impossible, guess)
    assert not solution.converged
    assert solution.violation > 0.1


def test_a_way_that_ends_nowhere(nao: Body, monkeypatch: pytest.MonkeyPatch) -> None:
    """Near an optimum, or far from the guess, all states are moved onto all constraints; elsewhere
    it is a failure.
    """
    problem, guess = problems(nao)[1]
    solver = SqpSolver(Collocation(nao.legs, SETTINGS))
    best = solver.solve(problem, guess)
    monkeypatch.setattr(sqp, "_ITERATIONS", 1)
    won = solver.solve(problem, guess)
    assert won.status == "Solved_Nearly"
    assert won.violation < 1e-7
    monkeypatch.setattr(sqp, "_WON", 1.0)
    assert solver.solve(problem, guess).status == "No_Progress"
    assert not solver.solve(problem, guess).converged
    monkeypatch.setattr(sqp, "_ITERATIONS", best.iterations - 1)
    solution = solver.solve(problem, guess)
    assert solution.status == "Solved_Nearly"
    assert solution.converged
    assert solution.violation < 1e-7
    assert solution.cost == pytest.approx(best.cost, rel=1e-2)


@pytest.mark.parametrize("horizon", [2, 20])
def test_horizons_of_any_length(nao: Body, horizon: int) -> None:
    collocation = Collocation(nao.legs, dataclasses.replace(SETTINGS, horizon=horizon))
    problem, guess = problems(nao)[0]
    guess = np.tile(guess[:1], (horizon, 1))
    solution = SqpSolver(collocation).solve(problem, guess)
    assert solution.converged
    limits = collocation.limits(problem)
    assert collocation.assess(problem, limits, solution.states)[1] < 1e-7


def test_the_same_problem_gives_the_same_bits(nao: Body) -> None:
    (one, guess), (other, elsewhere) = problems(nao)[:2]
    solver = SqpSolver(Collocation(nao.legs, SETTINGS))
    first = solver.solve(one, guess)
    solver.solve(other, elsewhere)
    again = solver.solve(one, guess)
    fresh = SqpSolver(Collocation(nao.legs, SETTINGS)).solve(one, guess)
    for solution in (again, fresh):
        np.testing.assert_array_equal(first.states, solution.states)
        assert (first.cost, first.iterations) == (solution.cost, solution.iterations)


def test_the_reference_alone_gives_as_good_a_motion() -> None:
    name = "odd_biped"
    body = load_body(name)
    reference = dataclasses.replace(SETTINGS, solver="ipopt")
    motion = type(planner_of(name))(body.robot, reference).plan(SUPPORTS[0])
    assert set(motion.path.statuses) == {"Solve_Succeeded"}
    assert "Solved" in motion_of(name).path.statuses
    reached = motion.path.nearest < SETTINGS.landmark_radius
    np.testing.assert_array_equal(reached, motion_of(name).path.nearest < SETTINGS.landmark_radius)
