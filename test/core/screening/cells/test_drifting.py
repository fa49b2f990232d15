"""Readings that drift over the session."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import RATE, SECONDS, Recording, recording
from core.screening.test_screen import screened
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.drifting import Drift, drifting
from shoecal_core.screening.faults import Fault
from shoecal_core.shoe.shoe import FEET

COUNT = 4
TOGETHER = dict.fromkeys(range(1, COUNT + 1), 0.0)


def course(run: int, constant: float = 0.0) -> FloatArray:
    """(T,) from 0 to 1 within the session of COUNT runs."""
    time = (run - 1) * SECONDS + np.arange(round(SECONDS * RATE)) / RATE
    last = COUNT * SECONDS
    if not constant:
        return np.asarray(time / last)
    return np.asarray(np.expm1(-time / constant) / np.expm1(-last / constant))


def growing(whole: Recording, share: float, constant: float = 0.0) -> Recording:
    return whole.with_readings(
        lambda run, values: values * (1.0 + share * course(run, constant)[:, None])
    )


def warming(whole: Recording, newtons: FloatArray, constant: float) -> Recording:
    volts = newtons / whole.parameters.gain
    return whole.with_readings(lambda run, values: values + course(run, constant)[:, None] * volts)


def found(whole: Recording) -> Drift | None:
    return drifting(whole.statics, TOGETHER)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shoe", ["nao_shoe", "odd_shoe"])
def test_sound_readings_do_not_drift(seed: int, shoe: str) -> None:
    assert found(recording(seed, count=COUNT, shoe=shoe)) is None


@pytest.mark.parametrize("share", [-0.08, -0.03, 0.05])
def test_a_supply_that_changes(share: float) -> None:
    drift = found(growing(recording(count=COUNT), share))
    assert drift is not None
    assert drift.readings == pytest.approx(share, rel=0.35)
    assert drift.constant == 0.0


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("foot", [0, 1])
def test_one_foot_whose_readings_grow(seed: int, foot: int) -> None:
    """Both seem to grow half as much, and both do not."""
    whole = recording(seed, count=COUNT)
    grows = (whole.shoe.foot == foot).astype(float)
    spoilt = whole.with_readings(
        lambda run, values: values * (1.0 + 0.08 * course(run)[:, None] * grows)
    )
    drift = found(spoilt)
    assert drift is not None
    assert drift.foot == foot
    assert drift.readings == pytest.approx(0.08, rel=0.35)
    (finding,) = screened(spoilt).findings
    assert (finding.verdict, finding.fault) == ("WARN", Fault.DRIFTING)
    assert f"all readings of the {FEET[foot]} foot grow alike" in finding.reason


@pytest.mark.parametrize("seed", range(3))
def test_cells_that_creep(seed: int) -> None:
    spoilt = growing(recording(seed, count=COUNT), 0.15, 20.0)
    drift = found(spoilt)
    assert drift is not None
    assert drift.readings == pytest.approx(0.15, rel=0.5)
    assert 10.0 <= drift.constant <= 40.0
    (finding,) = screened(spoilt).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.DRIFTING)
    assert "all readings grow alike, by" in finding.reason
    assert "creep" in finding.reason


@pytest.mark.parametrize("seed", range(5))
def test_boards_that_warm_up(seed: int) -> None:
    """Also where the zeros' sum stays, so that no force is missing."""
    whole = recording(seed, count=COUNT)
    newtons = np.random.default_rng(seed).uniform(1.5, 4.0, 8) * np.array([1.0, -1.0] * 4)
    (finding,) = screened(warming(whole, newtons, 40.0)).findings
    assert finding.fault == Fault.DRIFTING
    assert "zeros drift by" in finding.reason
    assert "time constant about 40 s" in finding.reason


def test_boards_of_one_foot_whose_sum_stays() -> None:
    whole = recording(count=COUNT)
    newtons = np.array([0.0, 0.0, 0.0, 0.0, 2.0, -2.0, -2.0, 2.0])
    drift = found(warming(whole, newtons, 40.0))
    assert drift is not None
    assert drift.feet == (1,)
    assert drift.zero == pytest.approx(2.0, rel=0.2)


def test_two_runs_show_no_drift() -> None:
    whole = growing(recording(count=2), -0.08)
    assert drifting(whole.statics, TOGETHER) is None


def test_runs_that_start_again_at_zero_follow_each_other() -> None:
    whole = growing(recording(count=COUNT), -0.08)
    apart = {run: (run - 1) * (SECONDS + 3.0) for run in TOGETHER}
    first, second = found(whole), drifting(whole.statics, apart)
    assert first is not None
    assert second is not None
    assert second.readings == pytest.approx(first.readings, rel=0.1)
