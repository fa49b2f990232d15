"""Gauss-Newton with a prior, on problems whose minimum is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shoecal_core.calibration.least_squares import Prior, minimise
from shoecal_core.calibration.residuals import Normal, zero_normal
from shoecal_core.errors import ShoecalError

FloatArray = NDArray[np.float64]


def linear(matrix: FloatArray, target: FloatArray, vector: FloatArray) -> Normal:
    error = matrix @ vector - target
    return Normal(float(error @ error), matrix.T @ error, matrix.T @ matrix)


def test_without_data_the_fit_stays_at_the_prior() -> None:
    prior = Prior(np.array([3.0, -2.0, 0.5]), np.array([1.0, 0.1, 0.0]))
    fit = minimise(lambda _: zero_normal(3), prior, max_iterations=5)
    np.testing.assert_array_equal(fit.vector, prior.mean)
    np.testing.assert_allclose(fit.covariance, np.diag([1.0, 0.01, 0.0]))
    assert (fit.cost, fit.initial_cost, fit.gradient_norm) == (0.0, 0.0, 0.0)
    assert (fit.rank, fit.iterations) == (0, 0)


def test_a_linear_problem_is_ridge_regression() -> None:
    rng = np.random.default_rng(0)
    matrix, target = rng.normal(size=(20, 5)), rng.normal(size=20)
    prior = Prior(rng.normal(size=5), rng.uniform(0.1, 2.0, 5))
    fit = minimise(lambda v: linear(matrix, target, v), prior, max_iterations=5)
    information = matrix.T @ matrix + np.diag(1.0 / prior.std**2)
    expected = np.linalg.solve(information, matrix.T @ target + prior.mean / prior.std**2)
    np.testing.assert_allclose(fit.vector, expected, rtol=1e-10)
    np.testing.assert_allclose(fit.covariance, np.linalg.inv(information), rtol=1e-10)
    off = (fit.vector - prior.mean) / prior.std
    assert fit.cost == pytest.approx(np.sum((matrix @ expected - target) ** 2) + off @ off)
    assert fit.initial_cost == pytest.approx(np.sum((matrix @ prior.mean - target) ** 2))
    assert fit.gradient_norm < 1e-8
    assert fit.iterations == 1


def test_singular_values_and_directions_are_the_whitened_jacobian_s() -> None:
    rng = np.random.default_rng(1)
    matrix = rng.normal(size=(3, 5)) * np.array([100.0, 1.0, 0.01, 1.0, 1.0])
    prior = Prior(np.zeros(5), np.array([0.1, 1.0, 10.0, 0.0, 2.0]))
    fit = minimise(lambda v: linear(matrix, np.zeros(3), v), prior, max_iterations=5)
    free = prior.std > 0.0
    _, values, _ = np.linalg.svd(matrix[:, free] * prior.std[free])
    np.testing.assert_allclose(fit.singular_values, [*values, 0.0], atol=1e-6)
    assert fit.rank == int(np.sum(values > 1.0))
    for value, direction in zip(fit.singular_values, fit.directions, strict=True):
        assert direction[3] == 0.0
        assert np.linalg.norm(direction[free] / prior.std[free]) == pytest.approx(1.0)
        assert np.linalg.norm(matrix @ direction) == pytest.approx(value, abs=1e-6)


def test_fixed_parameters_do_not_move() -> None:
    matrix = np.array([[1.0, 1.0], [0.0, 1.0]])
    prior = Prior(np.array([0.0, 7.0]), np.array([1e3, 0.0]))
    fit = minimise(lambda v: linear(matrix, np.array([10.0, 0.0]), v), prior, max_iterations=5)
    assert fit.vector[1] == 7.0
    assert fit.vector[0] == pytest.approx(3.0, rel=1e-5)
    np.testing.assert_array_equal(fit.covariance[1], [0.0, 0.0])


def curved(vector: FloatArray) -> Normal:
    """Rosenbrock's valley, in which full Gauss-Newton steps overshoot."""
    x, y = vector
    error = np.array([10.0 * (y - x**2), 1.0 - x, np.arctan(20.0 * (x - 1.0))])
    slope = 20.0 / (1.0 + (20.0 * (x - 1.0)) ** 2)
    jacobian = np.array([[-20.0 * x, 10.0], [-1.0, 0.0], [slope, 0.0]])
    return Normal(float(error @ error), jacobian.T @ error, jacobian.T @ jacobian)


def test_a_curved_problem_needs_halved_steps_and_ends_at_its_minimum() -> None:
    tried = []

    def evaluate(vector: FloatArray) -> Normal:
        tried.append(vector)
        return curved(vector)

    fit = minimise(evaluate, Prior(np.array([-1.5, 2.0]), np.array([1e4, 1e4])), max_iterations=100)
    np.testing.assert_allclose(fit.vector, [1.0, 1.0], atol=1e-4)
    assert fit.gradient_norm < 1.0
    assert len(tried) > fit.iterations + 1
    assert fit.cost < fit.initial_cost


def test_steps_are_halved_by_the_cost_alone() -> None:
    """A trial that is not taken needs no derivatives; the end is the same."""
    prior = Prior(np.array([-1.5, 2.0]), np.array([1e4, 1e4]))
    plain = minimise(curved, prior, max_iterations=100)
    whole, alone = [], []

    def evaluate(vector: FloatArray) -> Normal:
        whole.append(vector)
        return curved(vector)

    def cost(vector: FloatArray) -> float:
        alone.append(vector)
        return curved(vector).cost

    fit = minimise(evaluate, prior, max_iterations=100, cost=cost)
    np.testing.assert_array_equal(fit.vector, plain.vector)
    assert fit.cost == plain.cost
    assert alone
    # At most two models a step: at its end, and where the whole step had led.
    assert len(whole) <= 2 * fit.iterations + 1


def test_where_it_begins_changes_the_steps_but_not_the_end() -> None:
    rng = np.random.default_rng(2)
    matrix, target = rng.normal(size=(20, 5)), rng.normal(size=20)
    prior = Prior(rng.normal(size=5), np.array([0.1, 1.0, 0.0, 2.0, 1.0]))

    def evaluate(vector: FloatArray) -> Normal:
        return linear(matrix, target, vector)

    plain = minimise(evaluate, prior, max_iterations=5)
    again = minimise(evaluate, prior, max_iterations=5, start=plain.vector)
    elsewhere = minimise(evaluate, prior, max_iterations=5, start=rng.normal(size=5))
    assert again.iterations == 0
    for other in (again, elsewhere):
        np.testing.assert_allclose(other.vector, plain.vector, rtol=1e-9)
        np.testing.assert_allclose(other.covariance, plain.covariance, rtol=1e-9)
        # What is fixed stays at the prior's mean wherever it begins.
        assert other.vector[2] == prior.mean[2]
        # The cost before is told of the prior's mean, not of the start.
        assert other.initial_cost == pytest.approx(plain.initial_cost)


def test_too_few_iterations_are_told() -> None:
    prior = Prior(np.array([-1.5, 2.0]), np.array([1e4, 1e4]))
    with pytest.raises(ShoecalError, match="did not settle within 2 iterations"):
        minimise(curved, prior, max_iterations=2)


def test_one_iteration_is_enough_for_a_linear_problem() -> None:
    prior = Prior(np.zeros(1), np.ones(1))
    fit = minimise(lambda v: linear(np.ones((4, 1)), np.ones(4), v), prior, max_iterations=1)
    assert fit.vector[0] == pytest.approx(0.8)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_cost_that_is_no_number_is_told(wrong: float) -> None:
    def evaluate(vector: FloatArray) -> Normal:
        return Normal(1.0 if vector[0] == 0.0 else wrong, np.ones(1), np.eye(1))

    with pytest.raises(ShoecalError, match="cannot lower its cost"):
        minimise(evaluate, Prior(np.zeros(1), np.ones(1)), max_iterations=5)


def test_a_gradient_that_points_uphill_is_told() -> None:
    def evaluate(vector: FloatArray) -> Normal:
        return Normal(float(np.exp(vector[0])), -np.ones(1), np.eye(1))

    with pytest.raises(ShoecalError, match="cannot lower its cost"):
        minimise(evaluate, Prior(np.zeros(1), np.ones(1)), max_iterations=5)
