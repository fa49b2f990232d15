from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_coeffs, savgol_filter

from shoecal_core.samples.local_cubic import local_cubics, middle_weights


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize(
    ("count", "window", "period"), [(5, 5, 0.01), (80, 31, 0.02), (64, 7, 1.0)]
)
def test_it_is_scipys_filter(
    rng: np.random.Generator, count: int, window: int, period: float, order: int
) -> None:
    values = rng.normal(size=(count, 2, 3))
    wanted = savgol_filter(values, window, 3, deriv=order, delta=period, axis=0)
    found = local_cubics(values, window, period, order)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())
    # Theirs are in the order of a convolution.
    weights = savgol_coeffs(window, 3, deriv=order, delta=period)[::-1]
    np.testing.assert_allclose(
        middle_weights(window, period, order), weights, rtol=1e-9, atol=1e-9 * np.abs(weights).max()
    )


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_cubic_is_kept_to_its_ends(rng: np.random.Generator, order: int) -> None:
    cubic = np.polynomial.Polynomial(rng.normal(size=4))
    time = 0.05 * np.arange(40)
    found = local_cubics(cubic(time)[:, None], 9, 0.05, order)[:, 0]
    np.testing.assert_allclose(found, cubic.deriv(order)(time), atol=1e-9)
