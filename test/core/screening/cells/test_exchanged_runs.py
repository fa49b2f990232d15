"""Feet that are exchanged in some of the runs alone."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, recording
from core.shoe.shoes import made, six_axis
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.exchanged_runs import ExchangedRuns, exchanged_runs
from shoecal_core.screening.cells.wiring import exchanged, of_feet
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen


def found(whole: Recording) -> ExchangedRuns | None:
    return exchanged_runs(whole.statics)


def with_exchanged(whole: Recording, *runs: int) -> Recording:
    place = exchanged(np.arange(len(whole.shoe.names)), of_feet(whole.shoe))

    def changed(run: int, readings: FloatArray) -> FloatArray:
        return readings[:, place] if run in runs else readings

    return whole.with_readings(changed)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("runs", [(1,), (2,), (2, 3)])
def test_runs_with_exchanged_feet_are_named(seed: int, runs: tuple[int, ...]) -> None:
    whole = with_exchanged(recording(seed, count=5), *runs)
    exchange = found(whole)
    assert exchange is not None
    assert exchange.runs == runs
    assert exchange.off > 5.0 * exchange.left


def test_it_is_the_first_that_is_said() -> None:
    whole = with_exchanged(recording(1, count=5), 3)
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert finding.fault is Fault.SWAPPED
    assert finding.reason.startswith("run 3: left and right are exchanged, though not in the")


def test_of_six_axis_sensors() -> None:
    whole = recording(
        2, count=4, shoe=made([*six_axis(0, [0.0, 0.0, 0.03]), *six_axis(1, [0.0, 0.0, 0.03])])
    )
    assert found(whole) is None
    exchange = found(with_exchanged(whole, 4))
    assert exchange is not None
    assert exchange.runs == (4,)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_sound_recordings_and_those_exchanged_throughout_have_none(count: int) -> None:
    whole = recording(5, count=count)
    assert found(whole) is None
    assert found(with_exchanged(whole, *whole.aligned)) is None
