"""Errors that a calibration file states: those of the fit that it is of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation.drawn import TOLERANCES, Drawn
from core.estimation.standing import calibration
from shoecal_core.estimation.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.estimation.uncertainty.expected import (
    ErrorModel,
    over_polygons,
    support_covariance,
)
from shoecal_core.estimation.uncertainty.stated_error import RIGHT, StatedError, turns_to
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SUPPORT = DoubleSupport(0.02, -0.12, 0.2)


@pytest.fixture(scope="module")
def model(known: Drawn) -> ErrorModel:
    fit = known.fit
    samples = fit.signal_model.samples
    return ErrorModel.of(
        samples.robot, fit.shoe, samples.shoe, fit.parameters, *fit.measuring,
        support_covariance(fit, TOLERANCES), TOLERANCES,
    )  # fmt: skip


@pytest.fixture(scope="module")
def filed(model: ErrorModel, tmp_path_factory: pytest.TempPathFactory) -> Calibration:
    """Of that fit, written and read."""
    file, own = tmp_path_factory.mktemp("filed") / "calibration.yaml", 2 * len(model.shoe.names)
    whole = replace(
        calibration(model.filed, model.parameters),
        covariance=model.stated.covariance[:own, :own],
        columns=model.shoe.columns,
        column_covariance=model.stated.covariance[own:],
        support_covariance=model.support_covariance,
    )
    save_calibration(whole, file)
    return load_calibration(file)


def stated_of(model: ErrorModel, calibration: Calibration) -> StatedError:
    found = StatedError.of_calibration(calibration, model.robot, model.filed, TOLERANCES)
    assert found is not None
    return found


@pytest.fixture
def stated(model: ErrorModel, filed: Calibration) -> StatedError:
    return stated_of(model, filed)


def test_one_sample_of_a_file_says_what_the_report_says(
    model: ErrorModel, stated: StatedError
) -> None:
    both, *feet = model.load_cases()
    expected = model.both_feet(both, SUPPORT)
    for index, readings in enumerate(model.parameters.readings(both)):
        one = stated.at(readings).both(turns_to(SUPPORT)).output_covariance
        np.testing.assert_allclose(np.sqrt(np.diag(one)[1:]), expected.cop[index], rtol=1e-9)
        np.testing.assert_allclose(np.sqrt(one[0, 0]), expected.grf[index], rtol=1e-9)
    for foot, outputs in enumerate(feet):
        expected = model.foot(outputs, foot)
        for index, readings in enumerate(model.parameters.readings(outputs)):
            one = stated.at(readings).foot(foot).output_covariance
            np.testing.assert_allclose(np.sqrt(np.diag(one)[1:]), expected.cop[index], rtol=1e-9)
            np.testing.assert_allclose(np.sqrt(one[0, 0]), expected.grf[index], rtol=1e-9)


def test_what_a_file_leaves_out_counts_as_exact(model: ErrorModel, filed: Calibration) -> None:
    """Errors of columns, and of joints, as in files of before; without a covariance nothing."""
    older = stated_of(model, replace(filed, column_covariance=None, support_covariance=None))
    readings = model.parameters.readings(model.load_cases()[0])
    count = len(model.shoe.names)
    less = replace(
        model,
        covariance=model.covariance[: 2 * count, : 2 * count],
        shoe_columns=np.zeros((0, count, 3)),
        support_covariance=support_covariance(None, TOLERANCES),
    )
    for one, other in zip(
        (older.at(readings).foot(0), older.at(readings).both(turns_to(SUPPORT))),
        (less.stated.at(readings).foot(0), less.stated.at(readings).both(turns_to(SUPPORT))),
        strict=True,
    ):
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9, atol=1e-12)
    unknown = replace(filed, covariance=None, column_covariance=None)
    assert StatedError.of_calibration(unknown, model.robot, model.filed, TOLERANCES) is None


def test_known_weights_do_not_rest_on_the_robots(model: ErrorModel, filed: Calibration) -> None:
    by_hand = stated_of(model, replace(filed, source="manual", fitted_runs=()))
    (readings, *_) = model.parameters.readings(model.load_cases()[0])
    weight = model.robot.mass_std * GRAVITY
    force = model.parameters.outputs(readings) @ model.shoe.columns[:, 0]
    force += sum(plates.mass_below for plates in model.shoe.plates) * GRAVITY
    variances = [
        one.at(readings).both(turns_to(SUPPORT)).covariance[0, 0]
        for one in (stated_of(model, filed), by_hand)
    ]
    expected = (weight * force / model.robot.weight) ** 2
    assert variances[0] - variances[1] == pytest.approx(expected)


def test_the_frame_of_the_sum_changes_nothing_but_the_frame(
    model: ErrorModel, stated: StatedError
) -> None:
    exact = replace(stated, support_covariance=np.zeros((3, 3)))
    sample = exact.at(model.parameters.readings(model.load_cases()[0]))
    left = sample.both(turns_to(SUPPORT)).output_covariance
    right = sample.both(turns_to(SUPPORT, RIGHT), RIGHT).output_covariance
    np.testing.assert_allclose(left[:, 0, 0], right[:, 0, 0], rtol=1e-9)
    turn = SUPPORT.rotation
    np.testing.assert_allclose(left[:, 1:, 1:], turn @ right[:, 1:, 1:] @ turn.T, atol=1e-14)


def test_of_a_foot_with_a_lost_reading_nothing_is_stated(
    model: ErrorModel, stated: StatedError
) -> None:
    shoe: Shoe = model.shoe
    readings = model.parameters.readings(model.load_cases()[0])
    lost = readings.copy()
    lost[:, shoe.of_foot(0)[1]] = np.nan
    found, whole = stated.at(lost), stated.at(readings)
    assert np.isnan(found.foot(0).covariance).all(axis=(1, 2)).all()
    np.testing.assert_array_equal(found.foot(1).covariance, whole.foot(1).covariance)
    assert np.isnan(found.both(turns_to(SUPPORT)).covariance).all()


def test_noise_of_readings_counts_where_it_is_given(model: ErrorModel, stated: StatedError) -> None:
    readings, own = model.parameters.readings(model.load_cases()[0]), model.shoe.of_foot(0)
    noise = np.full(len(model.shoe.names), 1e-3)
    more = stated.at(readings, noise).foot(0).covariance - stated.at(readings).foot(0).covariance
    by_noise = (model.parameters.gain * model.shoe.columns[:, 0] * noise)[own]
    np.testing.assert_allclose(more[:, 0, 0], np.sum(by_noise**2), rtol=1e-6)


def together(model: ErrorModel, gain: float, offset_n: float) -> StatedError:
    """All gains off by the same share, and all offsets by the same force; all else is exact."""
    count = len(model.filed.names)
    law = ChannelParameters(model.parameters.gain, np.zeros(count))
    off = np.concatenate((gain * law.gain, np.full(count, offset_n), np.zeros(3 * count)))
    return StatedError(
        model.filed, law, np.outer(off, off), 0.0, (0.0, 0.0), np.zeros((3, 3))
    )  # fmt: skip


def test_an_offset_in_every_cell_shifts_the_force_by_their_number(model: ErrorModel) -> None:
    """All offsets off together by 0.1 N: 0.8 N in both feet, 0.4 N in each."""
    got = over_polygons(together(model, 0.0, 0.1), model.robot, model.filed)
    assert [one.grf_rms for one in got] == pytest.approx([0.8, 0.4, 0.4])


def test_one_common_relative_gain_shifts_no_cop(model: ErrorModel) -> None:
    """Only the parts below the cells, which no gain scales, keep it from being exact."""
    got = over_polygons(together(model, 0.05, 0.0), model.robot, model.filed)
    assert got[0].grf_rms == pytest.approx(0.05 * model.robot.weight, rel=0.05)
    assert max(one.cop_length.max() for one in got) < 2e-4
