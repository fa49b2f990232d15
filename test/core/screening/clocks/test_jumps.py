"""A clock that is set while a session is recorded."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.clocks.test_smoothed import looking_back
from core.screening.clocks.test_time_offsets import fast, late, tracks
from core.screening.recordings import RATE, SECONDS, SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.clocks.jumps import clock_jump, describe_clock_jump
from shoecal_core.screening.clocks.timing import timing_of
from shoecal_core.screening.screen import screen

COUNT = 4


def set_at(whole: Recording, by: float, run: int, time: float) -> Recording:
    """Joint angles come later from this moment of a run on."""
    after = late(whole, by).aligned

    def changed(number: int, values: FloatArray) -> FloatArray:
        since = round(time * RATE) if number == run else 0 if number > run else len(values)
        return np.concatenate((values[:since], after[number].readings[since:]))

    return whole.with_readings(changed)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("by", [-0.3, 0.15, 0.5])
def test_a_jump_within_a_run_is_found(seed: int, by: float) -> None:
    found = clock_jump(tracks(set_at(recording(seed, count=COUNT), by, 2, SECONDS / 2)))
    assert found is not None
    assert found.run == 2
    assert found.time == pytest.approx(SECONDS / 2, abs=SECONDS / 4)
    assert found.size == pytest.approx(by, abs=0.03)


@pytest.mark.parametrize("seed", range(3))
def test_a_jump_between_runs_is_found(seed: int) -> None:
    found = clock_jump(tracks(set_at(recording(seed, count=COUNT), 0.3, 3, 0.0)))
    assert found is not None
    assert (found.before, found.run, found.time) == (2, 3, None)
    (finding,) = describe_clock_jump(found)
    assert finding.verdict == "FAIL"
    assert "joint angles come 0.30 s later" in finding.reason
    assert "between runs 2 and 3" in finding.reason


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("by", [-0.5, 0.0, 0.2])
def test_a_constant_offset_is_no_jump(seed: int, by: float) -> None:
    assert clock_jump(tracks(late(recording(seed, count=COUNT), by))) is None


@pytest.mark.parametrize("rate", [-0.01, 0.003, 0.012])
@pytest.mark.parametrize("set_anew", [True, False])
def test_a_fast_clock_is_no_jump(rate: float, set_anew: bool) -> None:
    whole = fast(recording(count=COUNT, seconds=60.0), rate, set_anew=set_anew)
    assert clock_jump(tracks(whole)) is None


def test_a_filter_is_no_jump() -> None:
    assert clock_jump(tracks(looking_back(recording(count=COUNT), 0.4))) is None


def test_no_run_shows_no_jump() -> None:
    assert clock_jump({}) is None
    assert describe_clock_jump(None) == []


def test_it_is_named_in_place_of_a_constant_offset() -> None:
    whole = set_at(recording(count=COUNT), 0.3, 2, SECONDS / 2)
    timing = timing_of(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS)
    found = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS, timing)
    (finding,) = [one for one in found.findings if "clock" in one.reason]
    assert "in run 2" in finding.reason
    assert [one for one in found.findings if "corrected in the fit" in one.reason] == []
