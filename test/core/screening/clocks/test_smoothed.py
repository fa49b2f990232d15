"""Readings that went through a filter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from core.screening.clocks.test_time_offsets import fast, late
from core.screening.recordings import (
    RATE,
    SETTINGS,
    WEIGHT,
    Recording,
    read_coarsely,
    recording,
)
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.clocks.smoothed import (
    HARMLESS_S,
    Smoothing,
    describe_smoothed,
    smoothing,
)
from shoecal_core.screening.clocks.time_offsets import cop_tracks
from shoecal_core.screening.clocks.timing import Timing
from shoecal_core.screening.screen import screen


def smoothed(whole: Recording, width: float) -> Recording:
    """By a filter without delay."""
    return whole.with_readings(
        lambda _, values: np.asarray(gaussian_filter1d(values, width * RATE, axis=0))
    )


def looking_back(whole: Recording, constant: float) -> Recording:
    """As firmware does: y += a (x - y)."""
    kept = np.exp(-1.0 / RATE / constant)

    def filtered(_: int, values: FloatArray) -> FloatArray:
        for at in range(1, len(values)):
            values[at] = kept * values[at - 1] + (1.0 - kept) * values[at]
        return values

    return whole.with_readings(filtered)


def found(whole: Recording) -> Smoothing | None:
    return smoothing(cop_tracks(whole.aligned, whole.shoe, WEIGHT, SETTINGS))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("width", [0.7, 0.8])
def test_the_width_is_found(seed: int, width: float) -> None:
    one = found(smoothed(recording(seed), width))
    assert one is not None
    assert one.width == pytest.approx(width, abs=0.15)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("constant", [0.8, 1.4])
def test_a_filter_of_first_order_is_found(seed: int, constant: float) -> None:
    one = found(looking_back(recording(seed), constant))
    assert one is not None
    assert one.back
    assert one.width == pytest.approx(constant, rel=0.3)


def test_a_late_filter_is_one_too() -> None:
    one = found(late(smoothed(recording(), 0.8), -0.1))
    assert one is not None
    assert one.width == pytest.approx(0.8, abs=0.15)


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.3])
def test_sound_readings_are_not_smoothed(noise: float) -> None:
    for seed in range(5):
        assert found(recording(seed, noise=noise)) is None


@pytest.mark.parametrize("bits", [8, 10])
def test_few_bits_are_no_filter(bits: int) -> None:
    assert found(read_coarsely(recording(), bits, 0.0)) is None


def test_a_mean_over_a_second_is_harmless() -> None:
    assert HARMLESS_S > 0.3
    box = recording().with_readings(
        lambda _, values: np.asarray(uniform_filter1d(values, round(RATE), axis=0))
    )
    assert found(box) is None


@pytest.mark.parametrize("by", [-0.6, -0.1, 0.1, 0.6])
def test_clocks_apart_are_no_filter(by: float) -> None:
    assert found(late(recording(), by)) is None


@pytest.mark.parametrize("rate", [-0.012, 0.003, 0.012])
def test_a_fast_clock_is_no_filter(rate: float) -> None:
    assert found(fast(recording(count=3, seconds=60.0), rate)) is None


def test_no_run_shows_nothing() -> None:
    whole = recording()
    assert smoothing(cop_tracks({}, whole.shoe, WEIGHT, SETTINGS)) is None


def test_it_is_told_by_what_it_costs() -> None:
    assert not describe_smoothed(None)
    assert [one.verdict for one in describe_smoothed(Smoothing(0.5))] == ["WARN"]
    (finding,) = describe_smoothed(Smoothing(1.0, back=True))
    assert "time constant of 1.0 s" in finding.reason
    whole = recording()
    wide = screen(
        whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS, Timing(smoothed=Smoothing(0.8))
    )
    (reason,) = (one.reason for one in wide.findings if one.verdict == "FAIL")
    assert "smoothed" in reason
    assert "0.8 s" in reason
