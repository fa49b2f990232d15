"""Oscillations of the readings that the motion does not make."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import RATE, SETTINGS, WEIGHT, Recording, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.hum import Hum, find_hum
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen


def with_hum(whole: Recording, frequency: float, size: float = 0.8) -> Recording:
    """So many newtons on each cell of the right foot; each run begins at another phase."""

    def hum(run: int, values: FloatArray) -> FloatArray:
        phase = 2.0 * np.pi * frequency * np.arange(len(values)) / RATE + run
        values[:, 4:] += size * np.sin(phase)[:, None] / whole.parameters.gain[4:]
        return values

    return whole.with_readings(hum)


def found(whole: Recording) -> Hum | None:
    return find_hum(whole.statics, list(whole.aligned))


@pytest.mark.parametrize("frequency", [0.24, 0.4, 1.1])
def test_hum_is_found_with_its_frequency(frequency: float) -> None:
    hum = found(with_hum(recording(3, count=4), frequency))
    assert hum is not None
    assert hum.frequency == pytest.approx(frequency, abs=0.01)


def test_it_is_named() -> None:
    whole = with_hum(recording(4, count=4), 0.31, 0.06)
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert finding.fault is Fault.HUM
    assert finding.reason.startswith("the readings oscillate at 0.31 Hz in all runs")


@pytest.mark.parametrize("seed", range(4))
def test_sound_recordings_have_none(seed: int) -> None:
    assert found(recording(seed, count=4)) is None


def test_what_the_motion_makes_is_none() -> None:
    """A force that follows the CoP, as of cells that bend."""
    whole = recording(5, count=4)
    time = np.arange(len(whole.aligned[1].time)) / RATE
    wave = np.sin(2.0 * np.pi * 0.3 * time)
    for run, one in whole.aligned.items():
        one.states.com[:, :, :2] = 0.02 * wave[:, None, None]
        whole = whole.with_run(run, readings=one.readings)
    assert found(with_hum(whole, 0.3)) is None
