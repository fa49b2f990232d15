"""How much readings tremble, whatever moves below."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.screening.noise import noise, resolution, spread

TIME = np.arange(4000) / 100.0
SLOW = np.sin(0.5 * TIME)[:, None]


@pytest.mark.parametrize("std", [1e-4, 0.01])
def test_slow_motion_is_no_noise(std: float) -> None:
    rng = np.random.default_rng(1)
    readings = SLOW + std * rng.standard_normal((len(TIME), 3))
    np.testing.assert_allclose(noise(readings), std, rtol=0.1)


def test_outliers_are_no_noise() -> None:
    rng = np.random.default_rng(1)
    readings = SLOW + 0.01 * rng.standard_normal((len(TIME), 1))
    readings[::50] += 5.0
    np.testing.assert_allclose(noise(readings), 0.01, rtol=0.15)


def test_a_coarse_converter_trembles_by_its_step() -> None:
    readings = np.rint(SLOW / 0.05) * 0.05
    np.testing.assert_allclose(resolution(readings), 0.05)
    np.testing.assert_allclose(noise(readings), 0.025)


def test_what_never_changes_has_no_noise() -> None:
    assert noise(np.ones((100, 2))).tolist() == [0.0, 0.0]
    assert noise(np.ones((2, 2))).tolist() == [0.0, 0.0]


def test_spread_of_normal_numbers() -> None:
    rng = np.random.default_rng(2)
    values = 3.0 * rng.standard_normal((20000, 1))
    values[:100] = 1e6
    np.testing.assert_allclose(spread(values), 3.0, rtol=0.05)
