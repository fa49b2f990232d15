"""A step of the closure that stays is told, and what a motion does is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.steps import EDGE, ONSETS, step_of, step_times

TIME = np.arange(0.0, 30.0, 0.2)


def course(seed: int) -> FloatArray:
    """(T, 3) what gears and encoders make of a slow motion [m, m, rad]."""
    rng = np.random.default_rng(seed)
    phase, period = rng.uniform(0.0, 2.0 * np.pi, 3), rng.uniform(12.0, 30.0, 3)
    moves = np.sin(2.0 * np.pi * TIME[:, None] / period + phase)
    scale = np.array([3e-4, 3e-4, 2e-3])
    found: FloatArray = scale * moves + rng.normal(0.0, 0.2 * scale, (len(TIME), 3))
    return found


@given(
    st.integers(0, 1000),
    st.floats(4.0, 26.0),
    st.sampled_from([(0.004, 0.0, 0.0), (0.0, -0.003, 0.02), (0.0, 0.0, -0.04)]),
)
def test_a_lasting_step_is_told(seed: int, onset: float, shift: tuple[float, ...]) -> None:
    way = np.clip((TIME - onset) / 0.3, 0.0, 1.0)[:, None]
    found = step_of(TIME, course(seed) + way * np.array(shift))
    assert found is not None
    time, told = found
    assert time == pytest.approx(onset, abs=0.6)
    assert np.all(np.abs(told - shift) < 0.1 * np.abs(shift) + [7e-4, 7e-4, 3e-3])


@given(st.integers(0, 1000), st.floats(0.3, 1.2))
def test_nothing_is_told_where_nothing_stays(seed: int, length: float) -> None:
    assert step_of(TIME, course(seed)) is None
    bump = np.where((TIME > 12.0) & (12.0 + length > TIME), 0.005, 0.0)
    assert step_of(TIME, course(seed) + bump[:, None] * [1.0, 0.0, 0.0]) is None


def test_a_motion_from_place_to_place_is_no_step() -> None:
    glide = 0.01 / (1.0 + np.exp(-(TIME - 15.0) / 2.0))
    assert step_of(TIME, course(1) + glide[:, None] * [1.0, 0.0, 0.0]) is None


def test_a_short_run_tells_none() -> None:
    assert step_of(TIME[:8], course(2)[:8]) is None


@given(st.integers(0, 1000), st.floats(4.0, 26.0), st.sampled_from([0, 1, 2]))
def test_a_step_is_among_the_moments_that_are_tried(seed: int, onset: float, axis: int) -> None:
    later = (onset < TIME)[:, None]
    times = step_times(TIME, course(seed) + later * np.array([3e-3, 3e-3, 0.03]) * np.eye(3)[axis])
    assert len(times) == ONSETS
    assert min(abs(time - onset) for time in times) < 0.3


def test_moments_are_told_apart_and_away_from_the_ends() -> None:
    first, second = sorted(step_times(TIME, course(3)))
    assert TIME[EDGE] <= first < second <= TIME[-EDGE]
    assert second - first >= 2 * EDGE * (TIME[1] - TIME[0])


def test_a_signal_that_never_changes_says_nothing_of_moments() -> None:
    still = np.hstack((course(4), np.full((len(TIME), 2), 0.3)))
    assert step_times(TIME, still) == step_times(TIME, course(4))


def test_in_a_short_run_no_moment_is_tried() -> None:
    assert step_times(TIME[: 4 * EDGE - 1], course(5)[: 4 * EDGE - 1]) == []
