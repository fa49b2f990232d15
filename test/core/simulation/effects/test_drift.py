from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, SIX_AXIS, item, shoes_with, through, warm
from shoecal_core.errors import FileError

FORCE = np.full((301, 8), 10.0)
"""N; an instant a second."""


@settings(max_examples=25)
@given(st.floats(-0.05, 0.05))
def test_zeros_drift_by_the_stated_rate_over_a_session(rate: float) -> None:
    shoes = shoes_with(item("zero_drift", "left", rate_n_per_s=rate))
    reached = through(shoes, FORCE, period=1.0)
    assert reached[-1, :4] - 10.0 == pytest.approx(np.full(4, 300.0 * rate))
    assert (reached[:, 4:] == 10.0).all()
    assert reached[0, 0] == 10.0


def test_a_drift_slows_down() -> None:
    drifted = through(shoes_with(item("zero_drift", "all", rate_n_per_s=0.01)), FORCE, period=1.0)
    rates = np.diff(drifted[:, 0])
    assert rates[0] == pytest.approx(0.0127, rel=0.01)
    assert rates[-1] == pytest.approx(0.0077, rel=0.01)


def test_spans_drift_in_proportion_to_the_force() -> None:
    shoes = shoes_with(item("span_drift", "left/rear_left", rate_per_s=1e-4))
    reached = through(shoes, FORCE * np.arange(1, 9), period=1.0)
    assert reached[-1, 2] == pytest.approx(30.0 * 1.03)
    assert reached[-1, [0, 1, 3]] == pytest.approx([10.0, 20.0, 40.0])


@pytest.mark.parametrize("rise", [5.0, -3.0])
def test_a_drift_by_the_kelvin_follows_the_shoes_temperature(rise: float) -> None:
    effects = (
        item("zero_drift", "all", per_kelvin_n_per_k=0.1),
        item("span_drift", "all", per_kelvin_per_k=0.01),
    )
    shoes = shoes_with(*effects, rules=warm(rise))
    reached = through(shoes, FORCE, period=1.0)[:, 0]
    warmer = rise * (1.0 - np.exp(-np.maximum(np.arange(301.0) - 10.0, 0.0) / 100.0))
    assert reached == pytest.approx(10.0 * (1.0 + 0.01 * warmer) + 0.1 * warmer)


def test_all_of_six_axis_sensors_means_their_vertical_forces() -> None:
    shoes = shoes_with(item("zero_drift", "all", rate_n_per_s=0.01), shoe=SIX_AXIS)
    drifted = through(shoes, np.zeros((2, 10)), period=100.0)[-1]
    assert [SIX_AXIS.names[index] for index in np.flatnonzero(drifted)] == ["left/fz", "right/fz"]


def test_shoes_that_stay_cold_drift_by_no_kelvin() -> None:
    with pytest.raises(FileError, match=r"location: the shoes of this reality do not warm up"):
        shoes_with(item("zero_drift", "all", per_kelvin_n_per_k=0.1), shoe=NAO)


def test_a_drift_may_follow_time_and_temperature() -> None:
    both = item("zero_drift", "all", rate_n_per_s=0.01, per_kelvin_n_per_k=0.1)
    reached = through(shoes_with(both, rules=warm(5.0)), FORCE, period=1.0)
    warmer = 5.0 * (1.0 - np.exp(-290.0 / 100.0))
    assert reached[-1] == pytest.approx(np.full(8, 13.0 + 0.1 * warmer))
