"""Offsets corrected from standstills."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.estimation import synthetic
from core.estimation.standing import (
    BOTH,
    TOLERANCE,
    WEIGHT,
    Standing,
    calibration,
    corrections,
    drifted,
    spread,
    stand,
)
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.standstill import compare
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, foot_wrenches
from shoecal_core.workflows.rezero import EQUAL_N, Rezeroed, RezeroError, rezero

HOUR_NS = 3600 * 10**9
STANCES = [BOTH, (WEIGHT, 0.0), (0.0, WEIGHT), (0.0, 0.0)]


def rezeroed(
    old: Calibration,
    shoe: Shoe,
    truth: ChannelParameters,
    standing: Standing,
    *,
    after_ns: int = HOUR_NS,
    largest: float = 50.0,
    temperature: float = float("nan"),
) -> Rezeroed:
    return rezero(
        old, shoe, standing.readings(truth), standing.body, TOLERANCE,
        largest=largest, made_ns=old.made_ns + after_ns, temperature=temperature,
    )  # fmt: skip


def off_truth(fresh: Calibration, truth: ChannelParameters) -> FloatArray:
    """(n,) by which the offsets are wrong [N]."""
    found: FloatArray = fresh.parameters.offset - truth.offset
    return found


def offset_stds(fresh: Calibration, slopes: FloatArray) -> FloatArray:
    """(k,) standard deviations of sums of offsets."""
    assert fresh.covariance is not None
    count = len(fresh.channels)
    found: FloatArray = np.sqrt(np.diag(slopes @ fresh.covariance[count:, count:] @ slopes.T))
    return found


@pytest.fixture
def drift(shoe: Shoe, rng: np.random.Generator) -> FloatArray:
    return rng.uniform(-1.0, 1.0, len(shoe.names))


@pytest.mark.parametrize("forces", STANCES)
@pytest.mark.parametrize("known", [False, True])
def test_measured_becomes_modelled(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray, forces: tuple[float, float],
    known: bool,
) -> None:  # fmt: skip
    standing = stand(shoe, forces)
    covariance = spread(shoe, np.random.default_rng(1)) if known else None
    old = calibration(shoe, drifted(truth, drift), covariance=covariance)
    found = rezeroed(old, shoe, truth, standing)
    fresh = found.calibration
    wrenches = foot_wrenches(shoe, fresh.parameters.outputs(standing.readings(truth)))
    expected = foot_wrenches(shoe, standing.felt)
    hanging = [foot for foot in (0, 1) if not forces[foot]]
    np.testing.assert_allclose(wrenches[hanging], 0.0, atol=1e-9)
    if hanging:
        np.testing.assert_allclose(wrenches, expected, atol=1e-6)
    if any(forces):
        assert found.before is not None
        assert found.after is not None
        assert abs(found.after.grf_error) < 1e-9
        assert found.after.cop_error < 1e-9
        assert not found.after.beyond
    else:
        assert found.before is None
    assert found.directions == (6 if hanging else 3)
    np.testing.assert_array_equal(fresh.parameters.gain, old.parameters.gain)
    np.testing.assert_allclose(fresh.parameters.offset - old.parameters.offset, found.change)
    if known:
        assert fresh.covariance is not None
        np.testing.assert_allclose(fresh.covariance, fresh.covariance.T)
        assert np.linalg.eigvalsh(fresh.covariance).min() > -1e-9
    else:
        assert fresh.covariance is None
        # No change does it with less.
        assert (
            np.linalg.norm(found.change) <= np.linalg.norm(drift) * (1.0 + 1e-6)
            or shoe.torque.any()
        )


@given(arrays(np.float64, 8, elements=st.floats(-1.0, 1.0)), st.sampled_from(STANCES))
def test_what_the_standstill_cannot_tell_stays(
    drift: FloatArray, forces: tuple[float, float]
) -> None:
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, np.random.default_rng(2))
    old = calibration(shoe, drifted(truth, drift))
    once = rezeroed(old, shoe, truth, stand(shoe, forces)).calibration
    twice = rezeroed(once, shoe, truth, stand(shoe, forces)).calibration
    np.testing.assert_allclose(twice.parameters.offset, once.parameters.offset, atol=1e-7)
    # + - - + of one foot changes neither its force nor its CoP.
    pattern = np.linalg.svd(shoe.columns[:4].T)[2][-1]
    before, after = (off_truth(one, truth)[:4] @ pattern for one in (old, once))
    assert after == pytest.approx(before, abs=1e-6)


def test_uncertain_offsets_change_most(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    count = len(shoe.names)
    own = np.full(count, 1e-3)
    own[:3] = 3.0  # one foot's cells, enough for every wrench
    covariance = np.diag(np.concatenate([np.full(count, 1e-9), own**2]))
    old = calibration(shoe, drifted(truth, np.full(count, 0.01)), covariance=covariance)
    found = rezeroed(old, shoe, truth, stand(shoe), after_ns=1)
    assert np.abs(found.change[3:]).max() < 0.05 * np.abs(found.change[:3]).max()


def test_the_corrected_cop_is_the_one_that_counts(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray, rng: np.random.Generator
) -> None:
    standing = stand(shoe)
    old = calibration(shoe, drifted(truth, drift), corrections=corrections(shoe, rng))
    fresh = rezeroed(old, shoe, truth, standing).calibration
    measured = fresh.sensing(shoe).measure(standing.readings(truth))
    np.testing.assert_allclose(measured.total_grf, WEIGHT, atol=1e-6)
    np.testing.assert_allclose(
        measured.combined_cop(standing.body.support()), standing.body.cop[0, 0], atol=1e-7
    )


# What is known afterwards


def test_what_was_corrected_is_known_as_well_as_weight_and_model(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray
) -> None:
    """The weight's own error is stated apart, where the gains were fitted to it."""
    standing = stand(shoe)
    covariance = spread(shoe, np.random.default_rng(1))
    old = calibration(shoe, drifted(truth, drift), covariance=covariance)
    fresh = rezeroed(old, shoe, truth, standing).calibration
    for again in (fresh, rezeroed(fresh, shoe, truth, standing).calibration):
        # Weight and model are as wrong the second time as they were the first.
        readings = standing.readings(truth)
        told = compare(again, shoe, readings, standing.body, (False, False), TOLERANCE)
        own = np.diag(told.variance(readings, again.covariance))
        np.testing.assert_allclose(np.sqrt(own), [EQUAL_N, *told.tolerance[1:]], rtol=1e-3)


def test_errors_of_columns_stay_in_what_is_known(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray
) -> None:
    """Offsets take up what wrong columns do at this standstill: there they do no more harm."""
    standing, count = stand(shoe), len(shoe.names)
    root = 1e-3 * np.random.default_rng(5).normal(size=(5 * count, 5 * count))
    joint = root @ root.T
    old = calibration(
        shoe,
        drifted(truth, drift),
        covariance=joint[: 2 * count, : 2 * count],
        column_covariance=joint[2 * count :],
    )
    fresh = rezeroed(old, shoe, truth, standing).calibration
    readings = standing.readings(truth)
    told = compare(fresh, shoe, readings, standing.body, (False, False), TOLERANCE)
    own = np.diag(told.variance(readings, fresh.joint_covariance))
    np.testing.assert_allclose(np.sqrt(own), [EQUAL_N, *told.tolerance[1:]], rtol=1e-3)
    assert fresh.joint_covariance is not None
    columns = slice(2 * count, None)
    np.testing.assert_allclose(fresh.joint_covariance[columns, columns], joint[columns, columns])


def test_the_rest_is_as_uncertain_as_the_drift_was_large(
    shoe: Shoe, truth: ChannelParameters
) -> None:
    count = len(shoe.names)
    covariance = np.zeros((2 * count, 2 * count))
    left = np.where(shoe.foot == 0, shoe.columns[:, 0], 0.0)[None]
    stds = []
    for size in (0.0, 1.0, 2.0):
        drift = np.where(shoe.torque, 0.0, size)
        old = calibration(shoe, drifted(truth, drift), covariance=covariance)
        fresh = rezeroed(old, shoe, truth, stand(shoe)).calibration
        stds.append(offset_stds(fresh, left)[0])
    assert 0.05 < stds[0] < stds[1] < stds[2]


def test_errors_lie_within_what_is_stated(shoe: Shoe, truth: ChannelParameters) -> None:
    rng, count = np.random.default_rng(7), len(shoe.names)
    old = calibration(shoe, truth, covariance=np.zeros((2 * count, 2 * count)))
    left = np.where(shoe.foot == 0, shoe.columns[:, 0], 0.0)[None]
    ratios = []
    for _ in range(200):
        drift = rng.normal(0.0, 0.5, count) * np.where(shoe.torque, 0.1, 1.0)
        standing = stand(shoe, off=rng.normal(0.0, TOLERANCE.cop, 2))
        now = drifted(truth, -drift)
        fresh = rezeroed(old, shoe, now, standing).calibration
        error = left @ off_truth(fresh, now)
        ratios.append((error / offset_stds(fresh, left))[0])
    assert 0.6 < np.std(ratios) < 1.3


def test_other_stances_add_what_one_cannot_tell(shoe: Shoe, truth: ChannelParameters) -> None:
    rng, count = np.random.default_rng(3), len(shoe.names)
    left = np.where(shoe.foot == 0, shoe.columns[:, 0], 0.0)[None]
    errors: list[list[float]] = []
    stated: list[list[float]] = []
    for _ in range(20):
        drift = rng.normal(0.0, 0.5, count) * np.where(shoe.torque, 0.1, 1.0)
        old = calibration(shoe, drifted(truth, drift), covariance=np.zeros((2 * count, 2 * count)))
        errors.append([])
        stated.append([])
        for forces in (BOTH, (WEIGHT, 0.0), (0.0, WEIGHT)):
            old = rezeroed(old, shoe, truth, stand(shoe, forces), after_ns=10**9).calibration
            errors[-1].append(abs(float((left @ off_truth(old, truth))[0])))
            stated[-1].append(float(offset_stds(old, left)[0]))
    first, *later = np.mean(errors, axis=0)
    assert max(later) < 0.2 * first
    first, *later = np.mean(stated, axis=0)
    assert max(later) < first


def test_two_supports_tell_more_than_one() -> None:
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, np.random.default_rng(2))
    drift = np.random.default_rng(4).normal(0.0, 0.5, 8)
    old = calibration(shoe, drifted(truth, drift), covariance=np.zeros((16, 16)))
    sizes = [np.linalg.norm(drift)]
    for support in (DoubleSupport(0.06, -0.12, -0.4), DoubleSupport(-0.03, -0.14, 0.5)):
        old = rezeroed(old, shoe, truth, stand(shoe, support=support), after_ns=10**9).calibration
        sizes.append(np.linalg.norm(off_truth(old, truth)))
    assert sizes[2] < sizes[1] < sizes[0]


# Other sources


def test_a_manual_calibration_is_not_spoilt_by_the_model(
    shoe: Shoe, truth: ChannelParameters
) -> None:
    standing = stand(shoe, off=np.array([0.004, 0.0]))
    good = calibration(shoe, truth, source="manual")
    found = rezeroed(good, shoe, truth, standing)
    assert found.calibration is good
    assert (found.directions, np.abs(found.change).max()) == (0, 0.0)
    assert "no more than weight and model may be off" in found.summary
    drift = np.where(shoe.torque, 0.0, 0.5)
    heavy = rezeroed(
        calibration(shoe, drifted(truth, drift), source="manual"), shoe, truth, standing
    )
    assert heavy.directions == 1
    assert heavy.after is not None
    assert heavy.after.grf_error == pytest.approx(0.0, abs=1e-9)
    assert heavy.after.cop_error > 0.002


def test_verdict_and_reasons_stay_however_often(shoe: Shoe, truth: ChannelParameters) -> None:
    old = calibration(shoe, truth, verdict="WARN", reasons=("WARN: odd",), fitted_runs=("ab",))
    fresh, identities = old, set()
    for count in range(4):
        law = drifted(truth, np.full(len(shoe.names), 0.01 * count))
        fresh = rezeroed(fresh, shoe, law, stand(shoe), temperature=30.0 + count).calibration
        identities.add(fresh.id)
    assert len(identities) == 4
    assert all(identity.startswith("rezero-") and len(identity) == 19 for identity in identities)
    assert fresh.verdict == "WARN"
    assert fresh.reasons == ("WARN: odd", "offsets of 'old' corrected at standstills since")
    assert (fresh.source, fresh.temperature, fresh.fitted_runs) == ("rezero", 33.0, ("ab",))
    assert fresh.made_ns == old.made_ns + 4 * HOUR_NS
    unknown = rezeroed(fresh, shoe, truth, stand(shoe)).calibration
    assert unknown.temperature == 33.0


def test_it_says_what_it_could_do(shoe: Shoe, truth: ChannelParameters) -> None:
    count = len(shoe.names)
    old = calibration(shoe, drifted(truth, np.where(shoe.torque, 0.0, 0.5)))
    both = rezeroed(old, shoe, truth, stand(shoe))
    assert f"from one double support 3 of {count} directions" in both.summary
    assert both.before is not None
    assert f"GRF by {abs(both.before.grf_error):.2f} N" in both.summary
    for foot in (0, 1):
        forces = (0.0, WEIGHT) if foot == 0 else (WEIGHT, 0.0)
        lifted = rezeroed(old, shoe, truth, stand(shoe, forces))
        assert f"{FEET[foot]} foot lifted 6 of {count} directions" in lifted.summary
    air = rezeroed(old, shoe, truth, stand(shoe, (0.0, 0.0)))
    assert "the feet in the air read zero again; from both feet in the air" in air.summary


# Refusals


def test_what_is_no_drift_is_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    old = calibration(shoe, drifted(truth, np.full(len(shoe.names), 8.0)))
    with pytest.raises(RezeroError, match="calibrate again"):
        rezeroed(old, shoe, truth, stand(shoe), largest=5.0)


def test_a_cell_that_tells_nothing_is_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    standing = stand(shoe)
    standing.felt[0] = np.nan
    with pytest.raises(ShapeError):
        rezeroed(calibration(shoe, truth), shoe, truth, standing)
