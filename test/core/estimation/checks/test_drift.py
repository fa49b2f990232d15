"""Drift told from a standstill."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.estimation import synthetic
from core.estimation.standing import (
    TOLERANCE,
    WEIGHT,
    calibration,
    drifted,
    spread,
    stand,
)
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import WrongShoeError
from shoecal_core.estimation.checks.drift import UnloadedError, check_drift, shares_model
from shoecal_core.estimation.checks.standstill import ModelTolerance
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

FINE = ModelTolerance(force=1e-6, cop=1e-9)


def test_without_drift_all_is_well(shoe: Shoe, truth: ChannelParameters) -> None:
    for forces in ((30.0, WEIGHT - 30.0), (WEIGHT, 0.0), (0.0, WEIGHT)):
        standing = stand(shoe, forces)
        found = check_drift(
            calibration(shoe, truth), shoe, standing.readings(truth), standing.body, TOLERANCE
        )
        assert not found.beyond
        assert found.grf_error == pytest.approx(0.0, abs=1e-9)
        assert found.cop_error == pytest.approx(0.0, abs=1e-9)


@given(
    st.floats(0.02, 2.0),
    st.floats(0.0, 0.01),
    arrays(np.float64, 8, elements=st.floats(-3.0, 3.0)),
)
def test_errors_are_those_of_the_sum(force: float, cop: float, drift: FloatArray) -> None:
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, np.random.default_rng(2))
    standing = stand(shoe, off=np.array([0.6, -0.8]) * cop)
    old = calibration(shoe, drifted(truth, drift))
    tolerance = ModelTolerance(force, 0.0025)
    found = check_drift(old, shoe, standing.readings(truth), standing.body, tolerance)
    assert found.grf_error == pytest.approx(drift.sum(), abs=1e-9)
    # 99.7 % of a normal error are within 2.968 standard deviations; half of the weight's counts.
    assert found.grf_limit == pytest.approx(0.5 * 2.968 * force, rel=1e-3)
    assert found.beyond == (found.grf_beyond or found.cop_beyond)
    assert f"{found.grf_error:+.2f} N" in found.reason
    assert "states no uncertainty" in found.reason
    assert found.cop_error == pytest.approx(
        np.linalg.norm(
            old.sensing(shoe)
            .measure(standing.readings(truth))
            .combined_cop(standing.body.support())
            - standing.body.cop[0, 0]
        )
    )


def test_a_foot_in_the_air_tells_its_own_drift(shoe: Shoe, truth: ChannelParameters) -> None:
    standing = stand(shoe, (0.0, WEIGHT))
    drift = np.zeros(len(shoe.names))
    drift[shoe.of_foot(0)[shoe.columns[shoe.of_foot(0), 0] == 1.0][0]] = 0.5
    old = calibration(shoe, drifted(truth, drift))
    found = check_drift(old, shoe, standing.readings(truth), standing.body, TOLERANCE)
    assert found.hanging == "left"
    assert found.hanging_error == pytest.approx(0.5)
    assert found.beyond
    assert not found.grf_beyond
    assert not found.cop_beyond
    assert "left foot in the air reads +0.50 N" in found.reason


@pytest.mark.parametrize("source", ["self", "manual"])
def test_the_stated_chance_of_a_false_alarm_holds(
    shoe: Shoe, truth: ChannelParameters, source: str
) -> None:
    rng = np.random.default_rng(5)
    covariance = spread(shoe, rng, force=0.1)
    # What a self-calibration is uncertain of, its model is; a manual one errs on its own.
    tolerance = FINE if source == "self" else ModelTolerance(0.05, 3e-4)
    draws = rng.multivariate_normal(np.zeros(2 * len(shoe.names)), covariance, 500)
    alarms = np.zeros(2)
    for draw in draws:
        gain, offset = np.split(draw, 2)
        law = ChannelParameters(truth.gain + gain, truth.offset + offset)
        off, weight = np.zeros(2), WEIGHT
        if source == "manual":
            off, weight = rng.normal(0.0, tolerance.cop, 2), rng.normal(WEIGHT, tolerance.force)
        standing = stand(shoe, off=off)
        old = calibration(shoe, law, covariance=covariance, source=source, weight=weight)
        found = check_drift(
            old, shoe, standing.readings(truth), standing.body, tolerance, false_alarm=0.05
        )
        alarms += [found.grf_beyond, found.cop_beyond]
    np.testing.assert_allclose(alarms / len(draws), 0.05, atol=0.03)


def test_uncertainty_that_is_shared_does_not_add_up(shoe: Shoe, truth: ChannelParameters) -> None:
    covariance, standing = spread(shoe, np.random.default_rng(1)), stand(shoe)
    limits = {
        source: check_drift(
            calibration(shoe, truth, covariance=covariance, source=source),
            shoe, standing.readings(truth), standing.body, TOLERANCE,
        ).grf_limit
        for source in ("self", "manual")
    }  # fmt: skip
    assert limits["self"] < limits["manual"]
    fitted = calibration(shoe, truth, source="rezero", fitted_runs=("ab",))
    assert shares_model(fitted)
    assert not shares_model(calibration(shoe, truth, source="rezero"))


def test_in_the_air_nothing_is_told(shoe: Shoe, truth: ChannelParameters) -> None:
    standing = stand(shoe, (0.0, 0.0))
    with pytest.raises(UnloadedError, match="on the floor"):
        check_drift(
            calibration(shoe, truth), shoe, standing.readings(truth), standing.body, TOLERANCE
        )


def test_another_shoes_calibration_is_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    names = tuple(f"other/{name}" for name in shoe.names)
    standing = stand(shoe)
    with pytest.raises(WrongShoeError):
        check_drift(
            calibration(shoe, truth, channels=names),
            shoe, standing.readings(truth), standing.body, TOLERANCE,
        )  # fmt: skip
