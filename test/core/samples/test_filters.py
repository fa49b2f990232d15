"""Lags, plays and slopes against what they are by definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.filters import (
    evenly,
    low_passed,
    play,
    resampled,
    rise,
    slope,
    typical_period,
)

TIME = np.arange(0.0, 20.0, 0.02)


@given(st.floats(0.1, 5.0), st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_a_step_is_followed_exponentially(constant: float, before: float, after: float) -> None:
    step = np.where(TIME < 5.0, before, after)[:, None]
    found = low_passed(step, TIME, constant)[:, 0]
    since = np.maximum(TIME - 5.0 + 0.02, 0.0)
    wanted = after + (before - after) * np.exp(-since / constant)
    np.testing.assert_allclose(found, wanted, atol=1e-6)


@given(st.floats(0.1, 5.0), st.integers(0, 100))
def test_a_play_stays_within_its_width_and_only_moves_when_pushed(width: float, seed: int) -> None:
    force = np.cumsum(np.random.default_rng(seed).normal(size=(200, 2)), axis=0)
    found = play(force, np.full(2, width))
    assert (np.abs(found - force) <= 0.5 * width + 1e-9).all()
    moved = np.diff(found, axis=0) != 0.0
    assert np.allclose(np.abs(found - force)[1:][moved], 0.5 * width)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_the_slope_of_a_line_and_of_a_parabola(rate: float, bend: float) -> None:
    values = (rate * TIME + bend * TIME**2)[:, None]
    inside = slice(50, -50)
    np.testing.assert_allclose(
        slope(values, TIME)[inside, 0], (rate + 2.0 * bend * TIME)[inside], atol=1e-6
    )


@given(st.floats(0.02, 3.0))
def test_what_comes_a_span_later_is_more_by_its_rise(span: float) -> None:
    """At the end it stays."""
    found = rise(np.cos(TIME)[:, None], TIME, span)[:, 0]
    wanted = np.sin(np.minimum(TIME + span, TIME[-1])) - np.sin(TIME)
    np.testing.assert_allclose(found, wanted, atol=1e-3)


# ---- stamps that jitter, and samples lost --------------------------------------------------------


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


@pytest.mark.parametrize("size", [2, 4, 16])
def test_the_period_of_samples_in_packets_is_their_mean(size: int) -> None:
    at = np.arange(2000)
    assert typical_period(0.01 * (at - at % size) + 2e-4 * (at % size)) == pytest.approx(0.01, 0.25)


def test_gaps_do_not_change_the_period() -> None:
    time: FloatArray = np.arange(3000) / 100.0
    assert typical_period(time[(time < 1.0) | (time > 20.0)]) == pytest.approx(0.01)
    assert typical_period(time[time % 1.0 < 0.3]) == pytest.approx(0.01)
