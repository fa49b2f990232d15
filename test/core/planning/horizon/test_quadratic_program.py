"""Steps of one program against its own constraints and a second method."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import NonlinearConstraint, minimize

from core.planning.bodies import Body
from core.planning.horizons import problems
from core.planning.motions import SETTINGS
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.linearisation import Inequalities, Linearisation, Linearised
from shoecal_core.planning.horizon.problem import HorizonProblem
from shoecal_core.planning.horizon.quadratic_program import QuadraticProgram
from shoecal_core.planning.legs import BALANCE


@dataclasses.dataclass(frozen=True)
class Case:
    """A problem of a few states, and where its program begins."""

    problem: HorizonProblem
    linear: Linearised
    inequalities: Inequalities
    program: QuadraticProgram


def case_of(body: Body, count: int = 3) -> Case:
    settings = dataclasses.replace(SETTINGS, horizon=count)
    collocation = Collocation(body.legs, settings)
    problem, guess = problems(body)[1]
    problem = dataclasses.replace(problem, scene=problem.scene.padded(collocation.edges))
    limits = collocation.limits(problem)
    states = guess[:count] + np.random.default_rng(0).uniform(-3e-3, 3e-3, guess[:count].shape)
    linear = Linearisation(collocation)(states, problem.scene)
    size = guess.shape[1]
    rows = collocation.edges + len(body.robot.collision_pairs) + BALANCE + 3 * size
    return Case(
        problem,
        linear,
        Inequalities(problem, limits),
        QuadraticProgram(count, size, rows, settings.transition_weight),
    )


def rows_after(case: Case, change: FloatArray) -> FloatArray:
    """Inequalities after a step, to first order."""
    linear, inequalities = case.linear, case.inequalities
    values = inequalities.values(linear)
    size = change.shape[1]
    slopes = np.concatenate([inequalities.scene.normals @ linear.tasks[:, :2], linear.rest], axis=1)
    values[:, : -2 * size] += np.einsum("nrk,nk->nr", slopes, change)
    values[:, -2 * size : -size] += change
    values[:, -size:] += np.diff(np.vstack([np.zeros(size), change]), axis=0)
    return values


def cost_after(case: Case, change: FloatArray) -> float:
    """Equation 9 with tasks to first order."""
    problem, linear = case.problem, case.linear
    tasks = linear.values.tasks + np.einsum("ntk,nk->nt", linear.tasks, change)
    before = [problem.start - problem.previous, problem.start]
    moves = np.diff(np.vstack([*before, linear.states + change]), 2, axis=0)
    pull = np.sum(problem.aim.weights * (tasks - problem.aim.targets) ** 2)
    return float(pull + SETTINGS.transition_weight * np.sum(moves**2))


def kept(case: Case, change: FloatArray) -> float:
    """Largest violation to first order."""
    values = rows_after(case, change)
    feet = case.linear.values.foot_error + np.einsum("nrk,nk->nr", case.linear.foot, change)
    low, high = case.inequalities.low - values, values - case.inequalities.high
    return max(float(np.abs(feet).max()), float(low.max()), float(high.max()))


def test_steps_keep_everything_to_first_order(body: Body) -> None:
    case = case_of(body)
    step = case.program.solve(case.problem, case.linear, case.inequalities)
    assert step is not None
    assert kept(case, step.change) < 1e-8
    nearest = case.program.nearest(case.linear, case.inequalities)
    assert kept(case, nearest) < 1e-8
    assert np.linalg.norm(nearest) <= np.linalg.norm(step.change)


def test_a_step_is_the_best(nao: Body) -> None:
    """Against a general method on the same program, in all directions and two states."""
    case = case_of(nao, 2)
    step = case.program.solve(case.problem, case.linear, case.inequalities)
    assert step is not None
    shape, linear, inequalities = step.change.shape, case.linear, case.inequalities
    bounded_low, bounded_high = np.isfinite(inequalities.low), np.isfinite(inequalities.high)

    def room(flat: FloatArray) -> FloatArray:
        values = rows_after(case, flat.reshape(shape))
        return np.concatenate(
            [
                (values - inequalities.low)[bounded_low],
                (inequalities.high - values)[bounded_high],
            ]
        )

    def feet(flat: FloatArray) -> FloatArray:
        slopes = np.einsum("nrk,nk->nr", linear.foot, flat.reshape(shape))
        return np.asarray(linear.values.foot_error + slopes).ravel()

    second = minimize(  # type: ignore[call-overload]  # its stubs know no lists of both kinds
        lambda flat: cost_after(case, flat.reshape(shape)),
        np.zeros(step.change.size),
        method="SLSQP",
        constraints=[NonlinearConstraint(feet, 0.0, 0.0), NonlinearConstraint(room, 0.0, np.inf)],
        options={"ftol": 1e-12, "maxiter": 300},
    )
    assert cost_after(case, step.change) == pytest.approx(second.fun, rel=1e-6)


def test_prices_balance_the_gradient(body: Body) -> None:
    """Across the free directions the feet bear what is left (the Lagrangian's gradient is zero)."""
    case = case_of(body)
    step = case.program.solve(case.problem, case.linear, case.inequalities)
    assert step is not None
    prices, size = step.prices, step.change.shape[1]
    borne = case.program.multipliers(case.problem, case.inequalities, step)[:, 5:]

    def lagrangian(flat: FloatArray) -> float:
        change = flat.reshape(step.change.shape)
        value = cost_after(case, change) + float(np.sum(prices * rows_after(case, change)))
        feet = np.einsum("nrk,nk->nr", case.linear.foot, change)
        return value + float(np.sum(borne * feet))

    flat = step.change.ravel()
    scale = float(np.abs(prices).max()) + 1.0
    for unit in np.eye(len(flat))[:: max(1, size // 4)]:
        slope = (lagrangian(flat + 1e-5 * unit) - lagrangian(flat - 1e-5 * unit)) / 2e-5
        assert abs(slope) < 1e-5 * scale


def test_an_impossible_programme_is_none(nao: Body) -> None:
    case = case_of(nao)
    case.inequalities.low[1, -1], case.inequalities.high[1, -1] = 1.0, 1.1
    assert case.program.solve(case.problem, case.linear, case.inequalities) is None
    # The feet at least.
    change = case.program.nearest(case.linear, case.inequalities)
    feet = case.linear.values.foot_error + np.einsum("nrk,nk->nr", case.linear.foot, change)
    np.testing.assert_allclose(feet, 0.0, atol=1e-12)


def test_curvature_that_is_not_convex_is_left_out(nao: Body) -> None:
    case = case_of(nao)
    count, size = case.linear.states.shape
    plain = case.program.solve(case.problem, case.linear, case.inequalities)
    concave = np.tile(-1e7 * np.eye(size), (count, 1, 1))
    left_out = case.program.solve(case.problem, case.linear, case.inequalities, None, concave)
    assert plain is not None
    assert left_out is not None
    assert kept(case, left_out.change) < 1e-8
