"""Offsets corrected at a standstill."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.model import robots
from core.sensing import shoes
from shoecal_core.calibration.calibration import Calibration, WrongShoeError
from shoecal_core.calibration.rezero import RezeroError, rezero
from shoecal_core.errors import ShapeError
from shoecal_core.model.kinematics import BodyStates
from shoecal_core.sensing.correction import CopCorrection
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import (
    ChannelParameters,
    at_cop,
    columns_in_left,
    combined,
    foot_wrenches,
    weight_below,
)

FloatArray = NDArray[np.float64]
ROBOTS = {"nao_shoe": "nao", "odd_shoe": "odd_biped"}


@pytest.fixture
def body(shoe: Shoe) -> BodyStates:
    """The robot in its posture."""
    kinematics = robots.kinematics(ROBOTS[shoe.name])
    return kinematics.states(kinematics.robot.posture[None])


@pytest.fixture
def calibration(shoe: Shoe, truth: ChannelParameters) -> Calibration:
    robot = robots.load(ROBOTS[shoe.name])
    return Calibration(
        id="self-1", source="self", made_ns=1, robot=robot.name, shoe=shoe.name,
        robot_hash=robot.digest, shoe_hash=shoe.digest, channels=shoe.names, parameters=truth,
        covariance=None, corrections=(), weight=robot.weight, time_offset=0.0,
        temperature=20.0, verdict="PASS", reasons=("every check passed",),
    )  # fmt: skip


def standing(shoe: Shoe, body: BodyStates, weight: float, share: float) -> FloatArray:
    """(n,) outputs of a robot at rest, `share` of its weight on the left foot."""
    support, place = body.support(), body.cop[0, 0]
    left = np.array([0.02, 0.0])
    right = support.left_to_right((place - share * left) / (1.0 - share)) if share < 1.0 else left
    force = np.array([share, 1.0 - share]) * weight
    wrenches = at_cop(force, np.stack((left if share < 1.0 else place, right)))
    np.testing.assert_allclose(combined(wrenches, support), at_cop(np.asarray(weight), place))
    outputs = np.zeros(len(shoe.names))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        felt = wrenches[foot] - weight_below(shoe)[foot]
        outputs[own] = np.linalg.pinv(shoe.columns[own].T) @ felt
    return outputs


def readings(truth: ChannelParameters, outputs: FloatArray, drift: FloatArray) -> FloatArray:
    """What the cells tell after their offsets have drifted."""
    return (outputs - truth.offset - drift) / truth.gain


def test_after_it_grf_and_cop_are_the_model_s(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates,
    rng: np.random.Generator,
) -> None:  # fmt: skip
    outputs = standing(shoe, body, calibration.weight, 0.45)
    drift = 0.3 * rng.normal(size=len(outputs))
    raw = readings(truth, outputs, drift)
    fresh, change = rezero(calibration, shoe, raw, body, largest=2.0, made_ns=7)
    np.testing.assert_array_equal(fresh.parameters.gain, truth.gain)
    np.testing.assert_allclose(fresh.parameters.offset, truth.offset + change)
    measured = fresh.sensing(shoe).measure(raw)
    assert measured.total_grf == pytest.approx(calibration.weight, abs=1e-9)
    np.testing.assert_allclose(measured.combined_cop(body.support()), body.cop[0, 0], atol=1e-10)
    assert (fresh.source, fresh.made_ns) == ("rezero", 7)
    assert fresh.id != calibration.id
    assert fresh.reasons[-1] == "offsets of 'self-1' corrected at a standstill"


def test_the_change_is_the_smallest_that_does_it(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates,
    rng: np.random.Generator,
) -> None:  # fmt: skip
    """Weighed by how uncertain each offset is: what is sure hardly moves."""
    outputs = standing(shoe, body, calibration.weight, 0.45)
    raw = readings(truth, outputs, 0.3 * rng.normal(size=len(outputs)))
    matrix = columns_in_left(shoe, body.support()).T
    count = len(outputs)
    root = rng.normal(size=(2 * count, 2 * count))
    for covariance in (None, root @ root.T):
        known = replace(calibration, covariance=covariance)
        _, change = rezero(known, shoe, raw, body, largest=9.0, made_ns=7)
        spread = 0.01 * np.eye(count)
        if covariance is not None:
            spread = spread + covariance[count:, count:]
        missing = at_cop(np.asarray(calibration.weight), body.cop[0, 0]) - combined(
            foot_wrenches(shoe, truth.outputs(raw)), body.support()
        )
        expected = spread @ matrix.T @ np.linalg.solve(matrix @ spread @ matrix.T, missing)
        np.testing.assert_allclose(change, expected, atol=1e-9)


@pytest.mark.parametrize("lifted", [False, True], ids=["one foot", "both feet"])
def test_feet_in_the_air_read_zero_afterwards(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates,
    rng: np.random.Generator, *, lifted: bool,
) -> None:  # fmt: skip
    outputs = standing(shoe, body, calibration.weight, 1.0)
    if lifted:
        own = shoe.of_foot(0)
        outputs[own] = -np.linalg.pinv(shoe.columns[own].T) @ weight_below(shoe)[0]
    raw = readings(truth, outputs, 0.1 * rng.normal(size=len(outputs)))
    fresh, _ = rezero(calibration, shoe, raw, body, largest=2.0, made_ns=7)
    wrenches = foot_wrenches(shoe, fresh.parameters.outputs(raw))
    np.testing.assert_allclose(wrenches[1], 0.0, atol=1e-9)
    weight = 0.0 if lifted else calibration.weight
    np.testing.assert_allclose(wrenches[0], at_cop(np.asarray(weight), body.cop[0, 0]), atol=1e-9)


def test_the_corrected_cop_is_made_right(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates,
    rng: np.random.Generator,
) -> None:  # fmt: skip
    corrections = []
    for foot in (0, 1):
        count = len(shoe.of_foot(foot))
        x, y = (1e-3 * rng.normal(size=4 + count) for _ in range(2))
        x[4:], y[4:] = 1e-4 * rng.normal(size=(2, count))
        wide = np.array([[-1e3] * count, [1e3] * count])
        corrections.append(CopCorrection(foot, x, y, np.array([[-1.0] * 2, [1.0] * 2]), wide))
    bent = replace(calibration, corrections=tuple(corrections))
    raw = readings(truth, standing(shoe, body, calibration.weight, 0.45), np.zeros(len(shoe.names)))
    fresh, _ = rezero(bent, shoe, raw, body, largest=9.0, made_ns=7)
    measured = fresh.sensing(shoe).measure(raw)
    np.testing.assert_allclose(measured.combined_cop(body.support()), body.cop[0, 0], atol=1e-6)
    assert measured.total_grf == pytest.approx(calibration.weight, abs=1e-4)


def test_more_than_a_drift_is_refused(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates
) -> None:
    outputs = standing(shoe, body, calibration.weight, 0.45)
    drift = np.full(len(outputs), 3.0)
    with pytest.raises(RezeroError, match="more than a drift"):
        rezero(calibration, shoe, readings(truth, outputs, drift), body, largest=2.0, made_ns=7)


def test_readings_and_shoes_that_do_not_fit_are_refused(
    shoe: Shoe, calibration: Calibration, body: BodyStates
) -> None:
    count = len(shoe.names)
    for wrong in (np.zeros(count - 1), np.zeros((1, count)), np.full(count, np.nan)):
        with pytest.raises(ShapeError, match="readings"):
            rezero(calibration, shoe, wrong, body, largest=2.0, made_ns=7)
    other = shoes.shoe("odd_shoe" if shoe.name == "nao_shoe" else "nao_shoe")
    with pytest.raises(WrongShoeError):
        rezero(calibration, other, np.zeros(count), body, largest=2.0, made_ns=7)


def test_noise_free_readings_need_no_change(
    shoe: Shoe, truth: ChannelParameters, calibration: Calibration, body: BodyStates
) -> None:
    raw = readings(truth, standing(shoe, body, calibration.weight, 0.45), np.zeros(len(shoe.names)))
    _, change = rezero(calibration, shoe, raw, body, largest=2.0, made_ns=7)
    np.testing.assert_allclose(change, 0.0, atol=1e-10)
