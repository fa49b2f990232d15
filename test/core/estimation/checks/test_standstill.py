"""What a standstill is compared with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation.derivatives import assert_jacobian
from core.estimation.standing import (
    BOTH,
    TOLERANCE,
    WEIGHT,
    calibration,
    corrections,
    drifted,
    spread,
    stand,
)
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.estimation.checks.standstill import (
    ModelTolerance,
    StandstillResiduals,
    compare,
    hanging_feet,
)
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workspace import config_dir

STANCES = [BOTH, (WEIGHT, 0.0), (0.0, WEIGHT), (0.0, 0.0)]


def found(
    shoe: Shoe, truth: ChannelParameters, law: ChannelParameters, forces: tuple[float, float]
) -> StandstillResiduals:
    standing = stand(shoe, forces)
    readings, old = standing.readings(truth), calibration(shoe, law)
    hanging = (not forces[0], not forces[1])
    assert hanging_feet(old, shoe, readings, standing.body) == hanging
    return compare(old, shoe, readings, standing.body, hanging, TOLERANCE)


@pytest.mark.parametrize("forces", STANCES)
def test_without_drift_nothing_differs(
    shoe: Shoe, truth: ChannelParameters, forces: tuple[float, float]
) -> None:
    differences = found(shoe, truth, truth, forces)
    np.testing.assert_allclose(differences.error, 0.0, atol=1e-9)
    rows = 6 if not all(forces) else 3
    assert differences.slopes.shape == (rows, len(shoe.names))
    assert differences.tolerance.shape == (rows,)


@pytest.mark.parametrize("forces", STANCES)
def test_slopes_are_the_derivatives(
    shoe: Shoe, truth: ChannelParameters, forces: tuple[float, float]
) -> None:
    start = np.full(len(shoe.names), 0.01)

    def error(drift: FloatArray) -> FloatArray:
        return found(shoe, truth, drifted(truth, drift), forces).error

    slopes = found(shoe, truth, drifted(truth, start), forces).slopes
    assert_jacobian(error, slopes, start, relative_step=1e-2)


@pytest.mark.parametrize("forces", STANCES)
def test_column_slopes_are_the_derivatives(
    shoe: Shoe, truth: ChannelParameters, forces: tuple[float, float]
) -> None:
    standing = stand(shoe, forces)
    readings, hanging = standing.readings(truth), (not forces[0], not forces[1])
    plain = calibration(shoe, truth)

    def differences(columns: FloatArray) -> StandstillResiduals:
        moved = replace(plain, columns=columns.reshape(-1, 3))
        return compare(moved, shoe, readings, standing.body, hanging, TOLERANCE)

    start = shoe.columns.ravel()
    slopes = differences(start).column_slopes
    steps = 1e-6 * np.eye(len(start))
    found = np.stack(
        [(differences(start + s).error - differences(start - s).error) / 2e-6 for s in steps], 1
    )
    np.testing.assert_allclose(slopes, found, rtol=1e-5, atol=1e-5)


def test_the_corrected_cop_counts(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    standing = stand(shoe)
    old = calibration(shoe, truth, corrections=corrections(shoe, rng))
    readings = standing.readings(truth)
    differences = compare(old, shoe, readings, standing.body, (False, False), TOLERANCE)
    measured = old.sensing(shoe).measure(readings).combined_cop(standing.body.support())
    expected = np.linalg.norm(measured - standing.body.cop[0, 0])
    assert differences.cop == pytest.approx(expected)
    assert differences.cop > 1e-3


def test_variance_is_that_of_draws(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    covariance, standing = spread(shoe, rng), stand(shoe)
    readings = standing.readings(truth)
    draws = rng.multivariate_normal(np.zeros(2 * len(shoe.names)), covariance, 1000)
    gains, offsets = np.split(draws, 2, axis=1)
    errors = [
        compare(
            calibration(shoe, ChannelParameters(truth.gain + gain, truth.offset + offset)),
            shoe, readings, standing.body, (False, False), TOLERANCE,
        ).error
        for gain, offset in zip(gains, offsets, strict=True)
    ]  # fmt: skip
    differences = found(shoe, truth, truth, BOTH)
    expected = np.sqrt(np.diag(differences.variance(readings, covariance)))
    np.testing.assert_allclose(np.std(errors, axis=0), expected, rtol=0.1)
    assert not differences.variance(readings, None).any()


def test_a_foot_that_only_rests_lightly_does_not_hang(shoe: Shoe, truth: ChannelParameters) -> None:
    light = stand(shoe, (WEIGHT - 4.0, 4.0))
    old = calibration(shoe, truth)
    assert hanging_feet(old, shoe, light.readings(truth), light.body) == (False, False)


def test_readings_of_another_shoe_are_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    with pytest.raises(ShapeError):
        hanging_feet(calibration(shoe, truth), shoe, np.zeros(3), stand(shoe).body)


def test_tolerances_come_from_robot_and_settings() -> None:
    robot = load_robot(config_dir() / "robots" / "nao.yaml")
    settings = CalibrationSettings(force_std_n=0.01, cop_std_m=0.004)
    assert ModelTolerance.of(robot, settings) == ModelTolerance(robot.mass_std * GRAVITY, 0.004)
    rough = CalibrationSettings(force_std_n=2.0)
    assert ModelTolerance.of(robot, rough).force == 2.0
