"""A cell whose zero does not stay, and forces from outside in every run."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SECONDS, WEIGHT, Recording, recording
from core.screening.test_screen import screened
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault


def wandering(whole: Recording, channel: int, newtons: float) -> Recording:
    """Its zero runs away within each run, and stays there until the next one."""
    gain = whole.parameters.gain[channel]
    runs = len(whole.aligned)

    def moved(run: int, values: FloatArray) -> FloatArray:
        course = (run - 1 + np.linspace(0.0, 1.0, len(values))) / runs
        return np.asarray(values + newtons / gain * course)

    return whole.with_channel(channel, moved)


@pytest.mark.parametrize("channel", [0, 3, 6])
@pytest.mark.parametrize("newtons", [-6.0, 12.0, 30.0])
def test_the_cell_is_named_with_how_far_it_wanders(channel: int, newtons: float) -> None:
    whole = recording(count=4)
    (finding,) = screened(wandering(whole, channel, newtons)).findings
    assert finding.fault is Fault.MOVED_ZEROS
    text = f"the zero of {whole.shoe.names[channel]} wanders by "
    assert finding.reason.startswith(text)
    force = float(finding.reason.removeprefix(text).split()[0])
    assert force == pytest.approx(abs(newtons), rel=0.15)


def test_a_cell_that_is_tared_before_each_run_is_no_broken_one() -> None:
    whole = recording(count=4)
    zeros = dict(zip(whole.aligned, (0.0, 7.0, -4.0, 9.0), strict=True))
    tared = whole.with_channel(
        3, lambda run, values: values + zeros[run] / whole.parameters.gain[3]
    )
    (finding,) = screened(tared).findings
    assert finding.fault is Fault.MOVED_ZEROS
    text = f"{whole.shoe.names[3]} has another zero in each run, by up to "
    assert finding.reason.startswith(text)
    assert float(finding.reason.removeprefix(text).split()[0]) == pytest.approx(13.0, rel=0.15)
    assert "take tare() out" in finding.reason


def test_two_cells_that_wander_are_not_blamed_on_one() -> None:
    both = wandering(wandering(recording(count=4), 1, 12.0), 6, -12.0)
    assert not any("wanders" in one.reason for one in screened(both).findings)


def held(whole: Recording, share: float, period: float) -> Recording:
    """A hand or a supply that wavers: all cells read less by up to a share, now and then."""
    time = np.arange(round(SECONDS * 100.0)) / 100.0
    offset, gain = whole.parameters.offset, whole.parameters.gain

    def less(run: int, values: FloatArray) -> FloatArray:
        wave = 0.5 * share * (1.0 + np.sin(2.0 * np.pi * time / period + run))
        return np.asarray(((values * gain + offset) * (1.0 - wave[:, None]) - offset) / gain)

    return whole.with_readings(less)


@pytest.mark.parametrize("period", [3.0, 7.0, 20.0])
@pytest.mark.parametrize("share", [0.07, 0.2])
def test_a_force_from_outside_in_all_runs_is_no_matter_of_cables(
    share: float, period: float
) -> None:
    (finding,) = screened(held(recording(count=4), share, period)).findings
    assert finding.verdict == "FAIL"
    assert finding.fault is Fault.PULLED
    text = "the vertical forces of runs 1, 2, 3 and 4 vary by up to "
    assert finding.reason.startswith(text)
    force = float(finding.reason.removeprefix(text).split()[0])
    assert 0.3 * share * WEIGHT < force < 1.2 * share * WEIGHT
