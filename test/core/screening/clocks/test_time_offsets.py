"""Readings and joints that are apart in time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.clocks.time_offsets import (
    LARGEST_S,
    CopTrack,
    clock_rate,
    cop_tracks,
    time_offset,
)


def late(whole: Recording, by: float) -> Recording:
    """Joint angles tell what was true `by` before: the readings are ahead."""
    time = whole.aligned[1].time

    def ahead(_: int, readings: FloatArray) -> FloatArray:
        return np.stack([np.interp(time + by, time, one) for one in readings.T], axis=1)

    return whole.with_readings(ahead)


def tracks(whole: Recording) -> dict[int, CopTrack]:
    return cop_tracks(whole.aligned, whole.shoe, WEIGHT, SETTINGS)


def found(whole: Recording) -> float:
    return time_offset(tracks(whole))


@pytest.mark.parametrize("by", [-0.8, -0.15, -0.06, 0.03, 0.12, 0.5])
def test_the_offset_is_found(by: float) -> None:
    assert found(late(recording(), by)) == pytest.approx(by, abs=0.01)


def test_clocks_that_agree_are_left_alone() -> None:
    for seed in range(3):
        assert found(recording(seed)) == 0.0


def test_runs_that_do_not_agree_tell_nothing() -> None:
    whole = recording()
    mixed = late(whole, 0.2).aligned[1], late(whole, -0.2).aligned[2]
    whole = whole.with_run(1, readings=mixed[0].readings)
    assert found(whole.with_run(2, readings=mixed[1].readings)) == 0.0


def test_one_run_tells_nothing() -> None:
    whole = late(recording(), 0.1)
    assert time_offset(cop_tracks({1: whole.aligned[1]}, whole.shoe, WEIGHT, SETTINGS)) == 0.0


def test_no_more_than_the_largest_is_looked_for() -> None:
    assert abs(found(late(recording(), 2.0))) <= LARGEST_S


BREAK_S = 5.0
"""From one run to the next."""


def fast(whole: Recording, rate: float, by: float = 0.0, *, set_anew: bool = True) -> Recording:
    """Readings of a clock that runs fast: those stamped t were taken at t / (1 + rate) - by.

    Args:
        set_anew: at the start of each run; else at that of the session.
    """
    since = starts(whole) if not set_anew else dict.fromkeys(whole.aligned, 0.0)

    def stamped(run: int, readings: FloatArray) -> FloatArray:
        time = whole.aligned[run].time
        taken = (time + since[run]) / (1.0 + rate) - since[run] - by
        return np.stack([np.interp(taken, time, one) for one in readings.T], axis=1)

    return whole.with_readings(stamped)


def starts(whole: Recording) -> dict[int, float]:
    lengths = {run: float(np.ptp(one.time)) + BREAK_S for run, one in whole.aligned.items()}
    return {run: sum(lengths[one] for one in lengths if one < run) for run in lengths}


def rate_of(whole: Recording) -> float:
    return clock_rate(starts(whole), tracks(whole))


RATES = st.floats(0.003, 0.012)
SIGNS = st.sampled_from((-1.0, 1.0))
FEW = settings(max_examples=10, deadline=None, derandomize=True)


@FEW
@given(seed=st.integers(0, 99), size=RATES, sign=SIGNS, by=st.floats(-0.2, 0.2))
def test_one_run_of_a_minute_shows_a_rate(seed: int, size: float, sign: float, by: float) -> None:
    whole = fast(recording(seed, count=1, seconds=60.0), sign * size, by)
    assert rate_of(whole) == pytest.approx(sign * size, abs=1e-3)


@FEW
@given(seed=st.integers(0, 99), size=st.floats(0.0015, 0.004), sign=SIGNS)
def test_runs_of_a_clock_that_is_not_set_between_them_show_less(
    seed: int, size: float, sign: float
) -> None:
    whole = recording(seed, count=5, seconds=20.0)
    found = rate_of(fast(whole, sign * size, set_anew=False))
    assert found == pytest.approx(sign * size, abs=5e-4)


@FEW
@given(seed=st.integers(0, 99), by=st.floats(-0.5, 0.5), count=st.integers(1, 5))
def test_a_constant_delay_is_no_rate(seed: int, by: float, count: int) -> None:
    assert rate_of(fast(recording(seed, count=count), 0.0, by)) == 0.0


@pytest.mark.parametrize("step", [-0.2, 0.2])
def test_a_driver_that_is_started_again_is_no_rate(step: float) -> None:
    """From one run on the delay is another one."""
    whole = recording(count=5, seconds=20.0)
    early, later = fast(whole, 0.0), fast(whole, 0.0, step)
    for run in (3, 4, 5):
        early = early.with_run(run, readings=later.aligned[run].readings)
    assert rate_of(early) == 0.0


@pytest.mark.parametrize("by", [-0.3, 0.15])
@pytest.mark.parametrize("since", [15.0, 40.0, 48.0])
def test_readings_that_come_late_from_some_time_on_are_no_rate(by: float, since: float) -> None:
    whole = recording(count=1, seconds=60.0)
    some = late(whole, by).aligned[1].readings
    busy = whole.aligned[1].time > since
    mixed = np.where(busy[:, None], some, whole.aligned[1].readings)
    assert rate_of(whole.with_run(1, readings=mixed)) == 0.0


def test_no_run_shows_no_rate() -> None:
    whole = recording()
    assert clock_rate({}, cop_tracks({}, whole.shoe, WEIGHT, SETTINGS)) == 0.0
