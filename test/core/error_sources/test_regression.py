"""Fits from sums against least squares with whole matrices."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.error_sources.regression import WhitenedProducts, solve

ROWS, BASE, MORE = 200, 3, 4


@pytest.mark.parametrize("columns", [(), (0,), (1, 3)])
def test_a_fit_is_least_squares_with_priors(columns: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    whole = rng.normal(size=(ROWS, BASE + MORE + 1))
    whole[:, -1] += whole[:, :-1] @ rng.normal(size=BASE + MORE)
    precision = rng.uniform(0.1, 10.0, BASE)
    std = np.array([0.3, 2.0, 0.1, 1.0])[list(columns)]
    found = solve(WhitenedProducts(whole.T @ whole, BASE, precision), columns, std)
    matrix = whole[:, [*range(BASE), *(BASE + one for one in columns)]]
    prior = np.diag(np.sqrt(np.concatenate((precision, 1.0 / std**2))))
    stacked, target = np.vstack((matrix, prior)), np.append(whole[:, -1], np.zeros(len(prior)))
    vector = np.linalg.lstsq(stacked, target, rcond=None)[0]
    np.testing.assert_allclose(found.vector, vector, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(stacked.T @ stacked), rtol=1e-6)
    assert found.squares == pytest.approx(float(np.sum((target - stacked @ vector) ** 2)))
