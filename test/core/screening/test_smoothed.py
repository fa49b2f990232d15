"""Readings that went through a filter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from core.screening.recordings import (
    RATE,
    SETTINGS,
    WEIGHT,
    Recording,
    read_coarsely,
    recording,
)
from core.screening.test_clocks import fast, late
from shoecal_core.screening.clocks import cop_tracks
from shoecal_core.screening.screen import screen
from shoecal_core.screening.smoothed import HARMLESS_S, describe_smoothed, smoothed_by
from shoecal_core.screening.timing import Timing


def smoothed(whole: Recording, width: float) -> Recording:
    """By a filter without delay."""
    return whole.with_readings(
        lambda _, values: np.asarray(gaussian_filter1d(values, width * RATE, axis=0))
    )


def found(whole: Recording) -> float:
    return smoothed_by(cop_tracks(whole.aligned, whole.shoe, WEIGHT, SETTINGS))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("width", [0.7, 0.8])
def test_the_width_is_found(seed: int, width: float) -> None:
    assert found(smoothed(recording(seed), width)) == pytest.approx(width, abs=0.15)


def test_a_late_filter_is_one_too() -> None:
    assert found(late(smoothed(recording(), 0.8), -0.1)) == pytest.approx(0.8, abs=0.15)


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.3])
def test_sound_readings_are_not_smoothed(noise: float) -> None:
    for seed in range(5):
        assert found(recording(seed, noise=noise)) == 0.0


@pytest.mark.parametrize("bits", [8, 10])
def test_few_bits_are_no_filter(bits: int) -> None:
    assert found(read_coarsely(recording(), bits, 0.0)) == 0.0


def test_a_mean_over_a_second_is_harmless() -> None:
    assert HARMLESS_S > 0.3
    box = recording().with_readings(
        lambda _, values: np.asarray(uniform_filter1d(values, round(RATE), axis=0))
    )
    assert found(box) == 0.0


@pytest.mark.parametrize("by", [-0.6, -0.1, 0.1, 0.6])
def test_clocks_apart_are_no_filter(by: float) -> None:
    assert found(late(recording(), by)) == 0.0


@pytest.mark.parametrize("rate", [-0.012, 0.003, 0.012])
def test_a_fast_clock_is_no_filter(rate: float) -> None:
    assert found(fast(recording(count=3, seconds=60.0), rate)) == 0.0


def test_no_run_shows_nothing() -> None:
    whole = recording()
    assert smoothed_by(cop_tracks({}, whole.shoe, WEIGHT, SETTINGS)) == 0.0


def test_it_is_told_by_what_it_costs() -> None:
    assert not describe_smoothed(0.0)
    assert [one.verdict for one in describe_smoothed(0.5)] == ["WARN"]
    whole = recording()
    wide = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS, Timing(smoothed=0.8))
    (reason,) = (one.reason for one in wide.findings if one.verdict == "FAIL")
    assert "smoothed" in reason
    assert "0.8 s" in reason
