"""Gains from walks whose model misses the same in every step, with zeros of each trial."""

from __future__ import annotations

import numpy as np
import pytest

from core.estimation.walks import ANKLES, WEIGHT, walk
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.fit import SelfCalibration, self_calibrate
from shoecal_core.estimation.walking_fit import (
    at_common_zeros,
    check_stances,
    common_zeros,
    walks,
)
from shoecal_core.samples.zeros import with_own_zeros
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import ChannelParameters

SETTINGS = CalibrationSettings(
    force_std_n=15.0, cop_std_m=0.01, correlation_s=0.5, offset_std_n=100.0
)
GAIN = np.tile([1.0, 1.0, 0.9, 1.0, 1.0], 2)
VERTICAL = [2, 7]


def fitted(runs: int) -> tuple[SelfCalibration, FloatArray]:
    """A calibration of some runs, and the standard deviations of its gains."""
    stances, zeros, _ = walk(range(1, runs + 1), np.random.default_rng(5), GAIN)
    assert walks(stances)
    common = common_zeros(ANKLES, zeros, range(1, runs + 1))
    stages = self_calibrate(
        ANKLES, at_common_zeros(ANKLES, stances, zeros, common), SETTINGS, common
    )
    return stages, np.sqrt(np.diag(stages.fit.covariance))[:10]


def test_no_gain_runs_away_with_more_runs() -> None:
    """A model that is wrong alike in every step must not win by repeating itself."""
    few, few_std = fitted(1)
    for runs in (3, 10):
        many, std = fitted(runs)
        assert np.abs(many.parameters.gain - few.parameters.gain).max() < 0.03
        np.testing.assert_allclose(std, few_std, rtol=0.2)
        assert (np.abs(many.parameters.gain - GAIN) < 1.96 * std + 0.02).all()


def test_vertical_gains_are_found() -> None:
    stages, std = fitted(3)
    np.testing.assert_allclose(stages.parameters.gain[VERTICAL], 0.9, atol=0.03)
    assert (std[VERTICAL] < 0.06).all()


def test_offsets_are_those_of_the_mean_zeros() -> None:
    stages, _ = fitted(3)
    _, _, true = walk((1, 2, 3), np.random.default_rng(5), GAIN)
    mean = np.mean(list(true.values()), axis=0)
    found = stages.parameters.outputs(mean)
    np.testing.assert_allclose(found[VERTICAL], 0.0, atol=1.0)


def test_a_run_of_another_day_is_right_with_its_own_zeros() -> None:
    stages, _ = fitted(3)
    stances, zeros, _ = walk((7,), np.random.default_rng(77), GAIN)
    shoe = ANKLES

    def off(parameters: ChannelParameters) -> float:
        sensing = Sensing(shoe, parameters)
        return float(
            np.mean([np.abs(sensing.measure(s.readings).total_grf - s.force) for s in stances])
        )

    assert off(stages.parameters) > 0.02 * WEIGHT
    assert off(with_own_zeros(shoe, stages.parameters, zeros)) < 0.02 * WEIGHT


def test_a_foot_that_never_hangs_keeps_the_wide_prior() -> None:
    stances, zeros, _ = walk((1, 2), np.random.default_rng(3), GAIN)
    left = [zero for zero in zeros if zero.foot == 0]
    common = common_zeros(ANKLES, left, (1, 2))
    assert np.isfinite(common.std[:5]).all()
    assert np.isnan(common.std[5:]).all()
    moved = at_common_zeros(ANKLES, stances, left, common)
    for before, after in zip(stances, moved, strict=True):
        np.testing.assert_array_equal(after.readings[:, 5:], before.readings[:, 5:])
    stages = self_calibrate(ANKLES, moved, SETTINGS, common)
    std = np.sqrt(np.diag(stages.fit.covariance))[10:20]
    assert std[7] > 3.0 * std[2]
    assert stages.parameters.gain[7] == pytest.approx(0.9, abs=0.1)


def test_a_walk_with_few_stances_says_what_it_found_and_needs() -> None:
    stances, _, _ = walk((1, 2), np.random.default_rng(3), GAIN)
    assert check_stances(stances) == []
    few = [one for one in stances if one.loaded == (True, False)][:2]
    (finding,) = check_stances(few)
    assert finding.verdict == "WARN"
    assert "2.0 s on the left foot alone, 0.0 s on the right foot alone" in finding.reason
    assert "at least 2 s on each foot alone are needed" in finding.reason
