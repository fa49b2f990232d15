"""Mean absolute errors (paper, eqs. 7 and 8)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shoecal_core.estimation.series import cop_mae, grf_mae


def test_grf_by_hand() -> None:
    found = grf_mae(np.array([10.0, 12.0, 9.0]), np.array([11.0, 11.0, 11.0]))
    assert found.mean == pytest.approx(4.0 / 3.0)
    assert found.std == pytest.approx(math.sqrt(2.0 / 9.0))
    assert found.count == 3


def test_cop_is_the_mean_of_the_norms_not_of_the_axes() -> None:
    measured = np.array([[3.0, 4.0], [0.0, 0.0], [5.0, 12.0]])
    found = cop_mae(measured, np.zeros((3, 2)))
    assert found.mean == pytest.approx((5.0 + 0.0 + 13.0) / 3.0)
    assert found.std == pytest.approx(np.std([5.0, 0.0, 13.0]))
    assert cop_mae(np.zeros((3, 2)), measured) == found


def test_samples_without_a_value_are_left_out_and_counted() -> None:
    measured = np.array([[3.0, 4.0], [np.nan, np.nan], [0.0, np.nan]])
    found = cop_mae(measured, np.zeros((3, 2)))
    assert (found.mean, found.std, found.count, found.left_out) == (5.0, 0.0, 1, 2)
    found = grf_mae(np.array([1.0, np.nan]), np.array([0.0, 0.0]))
    assert (found.count, found.left_out) == (1, 1)


def test_nothing_to_compare_is_no_zero_error() -> None:
    for found in (
        grf_mae(np.zeros(0), np.zeros(0)),
        cop_mae(np.full((2, 2), np.nan), np.zeros((2, 2))),
    ):
        assert found.count == 0
        assert math.isnan(found.mean)
        assert math.isnan(found.std)
