"""Boards that tare, or start again, while the robot stands on its feet."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from core.screening.recordings import RATE, SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.screening.cells.zero_jumps import zero_jumps
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen

WHOLE = recording(6)


def tared(whole: Recording, feet: tuple[int, ...], at_s: float, runs: tuple[int, ...]) -> Recording:
    """All channels of these feet read zero at that moment, and their load less that from then."""

    def change(run: int, values: FloatArray) -> FloatArray:
        if run in runs:
            own = np.isin(whole.shoe.foot, feet)
            values[round(at_s * RATE) :, own] -= values[round(at_s * RATE), own]
        return values

    return whole.with_readings(change)


@given(at_s=st.floats(1.0, 25.0), foot=st.integers(0, 1), run=st.integers(1, 3))
def test_one_board(at_s: float, foot: int, run: int) -> None:
    readings = WHOLE.aligned[run].readings[:, WHOLE.shoe.foot == foot]
    here = np.abs(readings[round(at_s * RATE)]) / np.ptp(readings, axis=0)
    assume(np.sum(here > 0.1) > 2 and here.max() > 0.4)  # else hardly anything is taken away
    (found,) = zero_jumps(WHOLE.shoe, tared(WHOLE, (foot,), at_s, (run,)).runs)
    assert (found.run, found.foot) == (run, foot)
    assert found.time == pytest.approx(at_s, abs=2.0 / RATE)


def test_it_is_named_before_all_that_it_looks_like() -> None:
    whole = tared(WHOLE, (0, 1), 2.0, (1, 2, 3))
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert finding.fault is Fault.MOVED_ZEROS
    assert finding.reason.startswith("runs 1, 2 and 3: the readings of both feet jump all at once")


@pytest.mark.parametrize("seed", range(4))
def test_sound_recordings_have_none(seed: int) -> None:
    whole = recording(seed)
    assert not zero_jumps(whole.shoe, whole.runs)


def lowered(values: FloatArray, own: IntArray, seconds: float) -> FloatArray:
    """The feet hang for 5 s, and are put down within so many seconds."""
    time = np.arange(len(values)) / RATE
    carried = np.clip((time - 5.0) / seconds, 0.0, 1.0)[:, None]
    air = -WHOLE.parameters.offset[own] / WHOLE.parameters.gain[own]
    values[:, own] = air + carried * (values[:, own] - air)
    return values


@pytest.mark.parametrize("seconds", [0.1, 0.5])
def test_a_robot_that_is_put_down_has_none(seconds: float) -> None:
    whole = WHOLE.with_readings(lambda _, values: lowered(values, np.arange(8), seconds))
    assert not zero_jumps(whole.shoe, whole.runs)


def test_a_robot_that_starts_with_a_jerk_has_none() -> None:
    """Within a sample the load goes elsewhere, by half of what each channel has in the run."""

    def jerk(_: int, values: FloatArray) -> FloatArray:
        share = np.resize([0.5, -0.5, 0.4, -0.6], values.shape[1])
        values[500:] += share * np.ptp(values, axis=0)
        return values

    assert not zero_jumps(WHOLE.shoe, WHOLE.with_readings(jerk).runs)


def test_a_cable_that_comes_off_is_another_fault() -> None:
    noise = np.random.default_rng(3).normal(0.0, 1e-4, (3000, 4))

    def off(_: int, values: FloatArray) -> FloatArray:
        values[1500:, :4] = noise[1500:]
        return values

    assert not zero_jumps(WHOLE.shoe, WHOLE.with_readings(off).runs)


def test_one_cell_is_another_fault() -> None:
    def jump(_: int, values: FloatArray) -> FloatArray:
        values[1500:] -= values[1500]
        return values

    whole = WHOLE.with_channel(2, jump)
    assert not zero_jumps(whole.shoe, whole.runs)
