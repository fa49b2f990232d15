"""Channels that are read twice."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, read_coarsely, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.same_readings import same_readings
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen


@pytest.mark.parametrize(("one", "other"), [(1, 2), (0, 7)])
def test_a_channel_that_is_read_twice(one: int, other: int) -> None:
    def twice(_: int, values: FloatArray) -> FloatArray:
        values[:, other] = values[:, one]
        return values

    whole = recording(2).with_readings(twice)
    assert same_readings(whole.runs) == [(one, other)]
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.TWINS)
    names = f"{whole.shoe.names[one]} and {whole.shoe.names[other]}"
    assert finding.reason.startswith(f"{names} read the same, to the last digit")


@pytest.mark.parametrize("bits", [6, 10])
def test_sound_ones_do_not(bits: int) -> None:
    assert not same_readings(recording(3).runs)
    assert not same_readings(read_coarsely(recording(3), bits, 0.0).runs)


def test_two_dead_channels_are_another_fault() -> None:
    def dead(_: int, values: FloatArray) -> FloatArray:
        values[:, 2:4] = 0.25
        return values

    assert not same_readings(recording(4).with_readings(dead).runs)


def test_channels_without_readings_are_another_fault() -> None:
    def lost(_: int, values: FloatArray) -> FloatArray:
        values[:, 2:4] = np.nan
        return values

    assert not same_readings(recording(4).with_readings(lost).runs)
