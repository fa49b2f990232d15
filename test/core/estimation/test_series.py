"""Measured, modelled and true GRF and CoP beside each other."""

from __future__ import annotations

import numpy as np
import pytest

from core.estimation import synthetic
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.series import (
    Series,
    errors,
    measured_series,
    modelled_series,
    truth_series,
)
from shoecal_core.recording.truth import Truth
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters


@pytest.fixture
def stance(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> Stance:
    return synthetic.stance(shoe, truth, synthetic.SUPPORTS[1], rng, count=80)


def series(count: int = 4, **changes: FloatArray) -> Series:
    zero: dict[str, FloatArray] = {
        "time": np.arange(count, dtype=np.float64),
        "grf": np.zeros(count),
        "cop": np.zeros((count, 2)),
        "foot_grf": np.zeros((count, 2)),
        "foot_cop": np.zeros((count, 2, 2)),
    }
    return Series(**zero | changes)


def test_exact_parameters_measure_the_model(
    shoe: Shoe, truth: ChannelParameters, stance: Stance
) -> None:
    measured, modelled = measured_series(Sensing(shoe, truth), stance), modelled_series(stance)
    np.testing.assert_array_equal(measured.time, stance.time)
    np.testing.assert_allclose(measured.grf, modelled.grf, atol=1e-10)
    np.testing.assert_allclose(measured.cop, modelled.cop, atol=1e-12)
    np.testing.assert_allclose(measured.foot_grf.sum(axis=1), modelled.grf, atol=1e-10)
    found = errors([(measured, modelled)])
    assert found.grf.mean < 1e-10
    assert found.cop.mean < 1e-12
    # The model does not know each foot's share, so it is no zero error either.
    assert found.foot_cop[0].count == found.foot_grf[1].count == 0
    assert set(found.to_json()) == {
        "grf_mae_n", "grf_std_n", "grf_samples", "cop_mae_mm", "cop_std_mm", "cop_samples",
    }  # fmt: skip


@pytest.mark.parametrize("foot", [0, 1])
def test_in_single_support_the_cop_is_the_standing_foot_s(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, foot: int
) -> None:
    stance = synthetic.single_stance(shoe, truth, foot, rng)
    measured = measured_series(Sensing(shoe, truth), stance)
    np.testing.assert_allclose(measured.cop, stance.cop, atol=1e-10)
    np.testing.assert_allclose(measured.grf, stance.force, atol=1e-9)
    assert np.isnan(measured.foot_cop[:, 1 - foot]).all()


def test_truth_is_taken_at_the_stance_s_times(stance: Stance) -> None:
    time = np.linspace(-1.0, 6.0, 15)
    foot_grf = np.stack((20.0 + time, 30.0 - 2.0 * time), axis=1)
    cop = np.stack((0.01 * time, -0.02 * time), axis=1)
    foot_cop = np.stack((cop, 2.0 * cop), axis=1)
    found = truth_series(Truth(0, time, cop, foot_cop, foot_grf), stance)
    np.testing.assert_allclose(found.foot_grf[:, 0], 20.0 + stance.time)
    np.testing.assert_allclose(found.grf, 50.0 - stance.time)
    np.testing.assert_allclose(found.cop[:, 1], -0.02 * stance.time, atol=1e-15)
    np.testing.assert_allclose(found.foot_cop[:, 1, 0], 0.02 * stance.time, atol=1e-15)


def test_a_foot_without_a_true_cop_is_left_out_and_counted(stance: Stance) -> None:
    time = np.linspace(0.0, 4.0, 81)
    foot_cop = np.zeros((81, 2, 2))
    foot_cop[40:, 1] = np.nan
    truth = Truth(0, time, np.zeros((81, 2)), foot_cop, np.full((81, 2), 25.0))
    reference = truth_series(truth, stance)
    found = errors([(series(80), reference)])
    assert found.foot_cop[0].count == 80
    assert 35 <= found.foot_cop[1].count <= 45
    assert found.foot_cop[1].count + found.foot_cop[1].left_out == 80
    told = found.to_json()
    assert told["right_cop_samples"] + told["right_cop_samples_left_out"] == 80
    assert "left_cop_samples_left_out" not in told


def test_errors_are_means_over_all_samples_of_all_runs() -> None:
    """Three samples off by 1 N, one run of one sample off by 5 N: 2 N, not 3 N."""
    one = series(3, grf=np.ones(3), cop=np.tile([3e-3, 4e-3], (3, 1)))
    other = series(1, grf=np.array([-5.0]), cop=np.zeros((1, 2)))
    found = errors([(one, series(3)), (other, series(1))])
    assert found.grf.mean == pytest.approx(2.0)
    assert found.grf.count == 4
    figures = found.to_json()
    assert figures["grf_mae_n"] == pytest.approx(2.0)
    assert figures["grf_std_n"] == pytest.approx(np.std([1.0, 1.0, 1.0, 5.0]))
    assert figures["cop_mae_mm"] == pytest.approx(3.75)
    assert figures["cop_std_mm"] == pytest.approx(np.std([5.0, 5.0, 5.0, 0.0]))


def test_each_foot_is_scored_by_itself() -> None:
    """One newton too much on the left and too little on the right: no error of the sum."""
    foot_cop = np.zeros((4, 2, 2))
    foot_cop[:, 1, 0] = 2e-3
    measured = series(foot_grf=np.tile([1.0, -1.0], (4, 1)), foot_cop=foot_cop)
    figures = errors([(measured, series())]).to_json()
    assert figures["grf_mae_n"] == figures["cop_mae_mm"] == 0.0
    assert figures["left_grf_mae_n"] == figures["right_grf_mae_n"] == 1.0
    assert figures["left_cop_mae_mm"] == 0.0
    assert figures["right_cop_mae_mm"] == pytest.approx(2.0)
