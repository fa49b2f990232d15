"""Readings and joints that are apart in time."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.clocks import LARGEST_S, time_offset


def late(whole: Recording, by: float) -> Recording:
    """Joint angles tell what was true `by` before: the readings are ahead."""
    time = whole.aligned[1].time

    def ahead(_: int, readings: FloatArray) -> FloatArray:
        return np.stack([np.interp(time + by, time, one) for one in readings.T], axis=1)

    return whole.with_readings(ahead)


def found(whole: Recording) -> float:
    return time_offset(whole.aligned, whole.shoe, WEIGHT, SETTINGS)


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
    assert time_offset({1: whole.aligned[1]}, whole.shoe, WEIGHT, SETTINGS) == 0.0


def test_no_more_than_the_largest_is_looked_for() -> None:
    assert abs(found(late(recording(), 2.0))) <= LARGEST_S
