"""Filters on stamps that jitter and with samples lost."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shoecal_core.samples.even import evenly, resampled
from shoecal_core.samples.filters import low_passed, slope

FloatArray = NDArray[np.float64]


def uneven() -> FloatArray:
    rng = np.random.default_rng(1)
    time = np.sort(np.arange(0.0, 10.0, 0.01) + rng.uniform(-0.004, 0.004, 1000))
    return np.delete(time, rng.choice(np.arange(1, 999), 200, replace=False))


def test_even_stamps_are_left_alone() -> None:
    time, values = np.arange(0.0, 1.0, 0.01), np.ones((100, 2))
    same, at = resampled(values, time)
    assert same is values
    assert at is time
    assert evenly(lambda even, period: even * period, values, time)[0, 0] == pytest.approx(0.01)


def test_a_slope_is_a_slope_whatever_the_stamps() -> None:
    time = uneven()
    found = slope(3.0 * time[:, None], time)
    np.testing.assert_allclose(found[60:-60], 3.0, atol=1e-6)


def test_a_lag_lasts_as_long_whatever_the_stamps() -> None:
    time = uneven()
    ramp = low_passed(time[:, None], time, 0.5)[:, 0]
    late = time - ramp
    np.testing.assert_allclose(late[time > 5.0], 0.5, atol=0.02)
