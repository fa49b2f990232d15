"""Random functions have the properties that laws rely on."""

from __future__ import annotations

import numpy as np
import pytest

from blind.functions import Smooth, bending, density, monotone
from blind.noise import CORNER_HZ, coloured

SEEDS = range(12)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_monotone_curve_rises_all_the_way(seed: int) -> None:
    curve, x = monotone(np.random.default_rng(seed)), np.linspace(-0.5, 1.5, 500)
    assert np.diff(curve(x)).min() >= 0.0
    np.testing.assert_allclose(curve(np.array([-0.2, 0.0, 1.0, 1.3])), [-0.2, 0.0, 1.0, 1.3])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_bending_curve_is_straight_then_bends_then_is_flat(seed: int) -> None:
    curve, x = bending(np.random.default_rng(seed)), np.linspace(-1.0, 2.0, 600)
    slopes = np.diff(curve(x)) / np.diff(x)
    assert np.diff(slopes).max() < 1e-6
    assert slopes[0] == pytest.approx(1.0)
    assert slopes[-1] == pytest.approx(0.0, abs=1e-9)


def test_smooth_functions_have_unit_variance_and_the_length_asked_for() -> None:
    length, step = 3.0, 0.6
    x = np.arange(0.0, 3000.0, 30.0)
    drawn = [Smooth.drawn(length, np.random.default_rng(seed)) for seed in range(40)]
    here = np.concatenate([one(x) for one in drawn])
    there = np.concatenate([one(x + step) for one in drawn])
    assert np.mean(here**2) == pytest.approx(1.0, rel=0.1)
    expected = np.exp(-0.5 * (step / length) ** 2)
    assert np.mean(here * there) / np.mean(here**2) == pytest.approx(expected, abs=0.01)


def test_the_integral_of_a_smooth_function_has_it_as_its_slope() -> None:
    rate, x = Smooth.drawn(2.0, np.random.default_rng(1)), np.linspace(0.0, 10.0, 4001)
    np.testing.assert_allclose(np.gradient(rate.integral(x), x)[1:-1], rate(x)[1:-1], atol=1e-4)
    assert rate.integral(x)[0] == 0.0


def test_densities_are_positive_and_sum_to_one() -> None:
    weights = density(np.linspace(-3.0, 1.0, 24), np.random.default_rng(2))
    assert weights.min() > 0.0
    assert weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("slope", [0.0, 1.0, 2.0])
def test_noise_has_the_slope_asked_for_below_its_corner_and_is_white_above(slope: float) -> None:
    count, rate = 2**15, 100.0
    noise = coloured((count, 8), rate, slope, np.random.default_rng(3))
    power = (np.abs(np.fft.rfft(noise, axis=0)) ** 2).mean(axis=1) / count
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    low = (frequency > 0.0) & (frequency < 0.3 * CORNER_HZ)
    found = np.polyfit(np.log(frequency[low]), np.log(power[low]), 1)[0]
    assert found == pytest.approx(-slope, abs=0.25)
    assert power[frequency > 10.0 * CORNER_HZ].mean() == pytest.approx(1.0, rel=0.05)
