"""Least squares with a prior, on problems whose minimum is known."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.least_squares import Prior, Rows, minimise


def linear(matrix: FloatArray, target: FloatArray) -> Rows:
    return lambda vector: (matrix @ vector - target, matrix)


def nothing(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.zeros(0), np.zeros((0, len(vector)))


def test_without_data_the_fit_stays_at_the_prior() -> None:
    prior = Prior(np.array([3.0, -2.0, 0.5]), np.array([1.0, 0.1, 0.0]))
    fit = minimise(nothing, prior)
    np.testing.assert_array_equal(fit.vector, prior.mean)
    np.testing.assert_allclose(fit.covariance, np.diag([1.0, 0.01, 0.0]))
    assert (fit.cost, fit.initial_cost, fit.gradient_norm) == (0.0, 0.0, 0.0)
    assert fit.rank == 0


def test_a_linear_problem_is_ridge_regression() -> None:
    rng = np.random.default_rng(0)
    matrix, target = rng.normal(size=(20, 5)), rng.normal(size=20)
    prior = Prior(rng.normal(size=5), rng.uniform(0.1, 2.0, 5))
    fit = minimise(linear(matrix, target), prior)
    information = matrix.T @ matrix + np.diag(1.0 / prior.std**2)
    expected = np.linalg.solve(information, matrix.T @ target + prior.mean / prior.std**2)
    np.testing.assert_allclose(fit.vector, expected, rtol=1e-8)
    np.testing.assert_allclose(fit.covariance, np.linalg.inv(information), rtol=1e-8)
    off = (fit.vector - prior.mean) / prior.std
    assert fit.cost == pytest.approx(np.sum((matrix @ expected - target) ** 2) + off @ off)
    assert fit.initial_cost == pytest.approx(np.sum((matrix @ prior.mean - target) ** 2))
    assert fit.gradient_norm < 1e-6


def test_singular_values_and_directions_are_the_whitened_jacobian_s() -> None:
    rng = np.random.default_rng(1)
    matrix = rng.normal(size=(3, 5)) * np.array([100.0, 1.0, 0.01, 1.0, 1.0])
    prior = Prior(np.zeros(5), np.array([0.1, 1.0, 10.0, 0.0, 2.0]))
    fit = minimise(linear(matrix, np.zeros(3)), prior)
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
    fit = minimise(linear(matrix, np.array([10.0, 0.0])), prior)
    assert fit.vector[1] == 7.0
    assert fit.vector[0] == pytest.approx(3.0, rel=1e-5)
    np.testing.assert_array_equal(fit.covariance[1], [0.0, 0.0])


def curved(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rosenbrock's valley, in which full Gauss-Newton steps overshoot."""
    x, y = vector
    error = np.array([10.0 * (y - x**2), 1.0 - x, np.arctan(20.0 * (x - 1.0))])
    slope = 20.0 / (1.0 + (20.0 * (x - 1.0)) ** 2)
    return error, np.array([[-20.0 * x, 10.0], [-1.0, 0.0], [slope, 0.0]])


CURVED = Prior(np.array([-1.5, 2.0]), np.array([1e2, 1e2]))


def test_a_curved_problem_ends_at_its_minimum() -> None:
    fit = minimise(curved, CURVED, 500)
    np.testing.assert_allclose(fit.vector, [1.0, 1.0], atol=1e-3)
    assert fit.gradient_norm < 1.0
    assert fit.cost < fit.initial_cost


def test_too_few_iterations_are_told() -> None:
    with pytest.raises(ShoecalError, match="did not settle within 2 evaluations"):
        minimise(curved, CURVED, 2)


def test_residuals_that_are_no_numbers_are_told() -> None:
    def wrong(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.full(3, np.nan), np.zeros((3, len(vector)))

    with pytest.raises(ShoecalError, match="do not fit the model at all"):
        minimise(wrong, Prior(np.zeros(1), np.ones(1)))
