"""Signed numbers that are read without their sign."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, Recording, read_coarsely, recording
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.wrapped import wrapped
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.screen import screen


def without_sign(
    whole: Recording, channels: tuple[int, ...], share: float, spans: float
) -> Recording:
    """These channels pass through zero at that share of their range, and come from the top.

    Args:
        spans: of the converter over the channel's range.
    """
    every = np.concatenate([one.readings for one in whole.aligned.values()])
    low, size = every.min(axis=0), np.ptp(every, axis=0)

    def read(_: int, values: FloatArray) -> FloatArray:
        moved = values - low - share * size
        unsigned = np.where(moved < 0.0, moved + spans * size, moved)
        own = np.isin(np.arange(values.shape[1]), channels)
        return np.where(own, unsigned, values)

    return whole.with_readings(read)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("spans", [3.0, 100.0])
def test_a_channel_that_wraps(share: float, spans: float) -> None:
    whole = without_sign(recording(3), (6,), share, spans)
    (one,) = wrapped(whole.runs)
    size = np.ptp(np.concatenate([one.readings[:, 6] for one in recording(3).aligned.values()]))
    assert one.channel == 6
    assert one.span == pytest.approx(spans * size, rel=0.02)
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.CODES)
    assert finding.reason.startswith(f"{whole.shoe.names[6]} jumps by ")


def test_several_are_one_line() -> None:
    whole = without_sign(recording(4), (0, 5), 0.5, 50.0)
    assert [one.channel for one in wrapped(whole.runs)] == [0, 5]
    (finding,) = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS).findings
    assert finding.reason.startswith(f"{whole.shoe.names[0]}, {whole.shoe.names[5]} jump by ")


@pytest.mark.parametrize("seed", range(4))
def test_sound_recordings_do_not(seed: int) -> None:
    whole = recording(seed)
    assert not wrapped(whole.runs)
    assert not wrapped(read_coarsely(whole, 8, 0.0).runs)


def test_a_contact_that_opens_does_not() -> None:
    def open_now_and_then(_: int, values: FloatArray) -> FloatArray:
        values[::97] = values.max() + 10.0 * np.ptp(values)
        return values

    assert not wrapped(recording(5).with_channel(2, open_now_and_then).runs)


def test_spikes_of_one_height_do_not() -> None:
    def spiky(_: int, values: FloatArray) -> FloatArray:
        values[200:1400:60] += 5.0 * np.ptp(values)
        return values

    assert not wrapped(recording(5).with_channel(2, spiky).runs)


def test_a_foot_that_steps_does_not() -> None:
    """In the air its cells tremble, on the floor they carry what they carry."""
    noise = np.random.default_rng(8).normal(0.0, 1e-3, (3000, 4))

    def stepping(_: int, values: FloatArray) -> FloatArray:
        down = np.arange(len(values)) % 100 < 50
        values[:, :4] = np.where(down[:, None], values[:, :4] + 99.0, noise[: len(values)])
        return values

    assert not wrapped(recording(6).with_readings(stepping).runs)
