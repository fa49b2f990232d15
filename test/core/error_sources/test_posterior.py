"""The linear solver with priors, against the definitions."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.error_sources.posterior import Posterior

RNG = np.random.default_rng(3)
ROWS = RNG.normal(size=(40, 5)) * np.array([1.0, 1e4, 1e-5, 1.0, 1e2])
STD = np.array([2.0, 1e-4, 3e5, 1e3, 1e-2])
TARGET = RNG.normal(size=40)
POSTERIOR = Posterior(ROWS.T @ ROWS, STD**-2.0)


def test_mean_and_covariance_are_those_of_the_stacked_least_squares() -> None:
    """Unknowns in units of their priors: rows of priors are a unit matrix."""
    stacked = np.vstack((ROWS * STD, np.eye(5)))
    wanted = np.linalg.lstsq(stacked, np.append(TARGET, np.zeros(5)), rcond=None)[0]
    np.testing.assert_allclose(POSTERIOR.solve(ROWS.T @ TARGET) / STD, wanted, rtol=1e-8)
    covariance = np.linalg.inv(stacked.T @ stacked)
    found = POSTERIOR.covariance / np.outer(STD, STD)
    np.testing.assert_allclose(found, covariance, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(POSTERIOR.variance, np.diag(POSTERIOR.covariance))


@pytest.mark.parametrize("columns", [(), (0,), (1, 3)])
def test_a_fit_is_least_squares_with_priors(columns: tuple[int, ...]) -> None:
    """Of columns that are always there and of some others, from the products of all."""
    rng = np.random.default_rng(1)
    whole = rng.normal(size=(200, 8))
    whole[:, -1] += whole[:, :-1] @ rng.normal(size=7)
    std = np.array([0.3, 2.0, 0.1, 1.0])[list(columns)]
    precision = np.concatenate((rng.uniform(0.1, 10.0, 3), std**-2.0))
    chosen = [*range(3), *(3 + one for one in columns)]
    products = whole.T @ whole
    found = Posterior(products[np.ix_(chosen, chosen)], precision)
    right = products[chosen, -1]
    stacked = np.vstack((whole[:, chosen], np.diag(np.sqrt(precision))))
    target = np.append(whole[:, -1], np.zeros(len(precision)))
    vector = np.linalg.lstsq(stacked, target, rcond=None)[0]
    np.testing.assert_allclose(found.solve(right), vector, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(stacked.T @ stacked), rtol=1e-6)
    squares = products[-1, -1] - right @ found.solve(right)
    assert squares == pytest.approx(float(np.sum((target - stacked @ vector) ** 2)))


def test_whitened_products_are_what_the_unknowns_take_of_the_squares() -> None:
    values = RNG.normal(size=(40, 2))
    across = POSTERIOR.whiten(ROWS.T @ values)
    taken = values.T @ ROWS @ POSTERIOR.covariance @ ROWS.T @ values
    np.testing.assert_allclose(across.T @ across, taken)
    solved = POSTERIOR.solve(ROWS.T @ values)
    np.testing.assert_allclose(POSTERIOR.unwhiten(across), solved)


def test_volume_is_the_ratio_of_determinants() -> None:
    scaled = ROWS * STD
    wanted = 0.5 * np.linalg.slogdet(np.eye(5) + scaled.T @ scaled)[1]
    assert POSTERIOR.half_log_volume == pytest.approx(wanted)


def test_nothing_to_fit_is_a_fit() -> None:
    nothing = Posterior(np.zeros((0, 0)), np.zeros(0))
    assert nothing.solve(np.zeros(0)).shape == (0,)
    assert nothing.solve(np.zeros((0, 3))).shape == (0, 3)
    assert nothing.covariance.shape == (0, 0)
    assert nothing.half_log_volume == 0.0


def test_columns_that_are_alike_share_what_they_explain() -> None:
    twice = np.column_stack((ROWS[:, 0], ROWS[:, 0]))
    found = Posterior(twice.T @ twice, np.full(2, 1e-16)).solve(twice.T @ TARGET)
    alone = Posterior(ROWS[:, :1].T @ ROWS[:, :1], np.full(1, 1e-16)).solve(ROWS[:, 0:1].T @ TARGET)
    np.testing.assert_allclose(found, 0.5 * alone[0], rtol=1e-3)


@pytest.mark.parametrize("normal", [np.full((2, 2), np.nan), -np.eye(2), np.full((2, 2), np.inf)])
def test_what_is_no_sum_of_squares_is_an_error(normal: np.ndarray) -> None:
    with pytest.raises(np.linalg.LinAlgError), np.errstate(all="ignore"):
        Posterior(normal, np.full(2, 0.1))
