"""Offsets corrected from one standstill."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from core.calibration import synthetic
from shoecal_core.calibration.calibration import Calibration
from shoecal_core.calibration.rezero import RezeroError, rezero
from shoecal_core.errors import ShapeError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.kinematics import BodyStates
from shoecal_core.sensing.correction import CopCorrection
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import (
    ChannelParameters,
    at_cop,
    combined,
    foot_wrenches,
    weight_below,
)

FloatArray = NDArray[np.float64]
SUPPORT = synthetic.SUPPORTS[1]
WEIGHT = 54.0
HEIGHT = 0.25
COPS = np.array([[0.02, 0.005], [0.03, -0.01]])
"""True CoP of left, right, each in its own sole's frame [m]."""


def calibration(
    shoe: Shoe,
    parameters: ChannelParameters,
    corrections: tuple[CopCorrection, ...] = (),
    covariance: FloatArray | None = None,
) -> Calibration:
    return Calibration(
        "old", "self", 1, "robot", shoe.name, "r", "s", shoe.names, parameters, covariance,
        corrections, WEIGHT, 0.0, float("nan"), "PASS", ("fine",),
    )  # fmt: skip


def outputs(shoe: Shoe, forces: tuple[float, float]) -> FloatArray:
    """(n,) outputs of channels that feel these forces [N] at COPS."""
    found = np.zeros(len(shoe.names))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        wanted = at_cop(np.array(forces[foot]), COPS[foot]) - weight_below(shoe)[foot]
        found[own] = np.linalg.lstsq(shoe.columns[own].T, wanted, rcond=None)[0]
    return found


def body(cop_left: FloatArray, support: DoubleSupport = SUPPORT) -> BodyStates:
    """A body whose CoM is above a place of the left sole's frame [m]."""
    rotation = np.eye(3)
    rotation[:2, :2] = support.rotation
    places = np.stack([cop_left, support.left_to_right(cop_left)])
    com = np.column_stack([places, [HEIGHT, HEIGHT]])
    return BodyStates(
        com=com[None],
        rotation=rotation[None],
        translation=np.array([[support.dx, support.dy, 0.0]]),
        left_rotation=np.eye(3)[None],
        left_translation=np.zeros((1, 3)),
    )


def standing(forces: tuple[float, float]) -> FloatArray:
    """(2,) CoP of both feet in the left sole's frame [m]."""
    right = SUPPORT.right_to_left(COPS[1])
    found: FloatArray = (forces[0] * COPS[0] + forces[1] * right) / sum(forces)
    return found


def drifted(truth: ChannelParameters, drift: FloatArray) -> ChannelParameters:
    return ChannelParameters(truth.gain, truth.offset + drift)


def readings(truth: ChannelParameters, felt: FloatArray) -> FloatArray:
    found: FloatArray = (felt - truth.offset) / truth.gain
    return found


@pytest.fixture
def drift(shoe: Shoe, rng: np.random.Generator) -> FloatArray:
    return rng.uniform(-1.0, 1.0, len(shoe.names))


def test_standing_on_both_feet(shoe: Shoe, truth: ChannelParameters, drift: FloatArray) -> None:
    forces = (30.0, WEIGHT - 30.0)
    raw = readings(truth, outputs(shoe, forces))
    old = calibration(shoe, drifted(truth, drift))
    fresh, change = rezero(old, shoe, raw, body(standing(forces)), largest=5.0, made_ns=9)
    total = combined(foot_wrenches(shoe, fresh.parameters.outputs(raw)), SUPPORT)
    np.testing.assert_allclose(total, at_cop(np.array(WEIGHT), standing(forces)), atol=1e-9)
    np.testing.assert_array_equal(fresh.parameters.gain, old.parameters.gain)
    np.testing.assert_allclose(fresh.parameters.offset - old.parameters.offset, change)
    assert (fresh.source, fresh.made_ns) == ("rezero", 9)
    assert fresh.id != old.id
    # No change does it with less.
    assert np.linalg.norm(change) <= np.linalg.norm(drift) + 1e-9


def test_uncertain_offsets_change_most(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    count = len(shoe.names)
    spread = np.full(count, 1e-3)
    spread[:3] = 3.0  # one foot's cells, enough for every wrench
    covariance = np.diag(np.concatenate([np.ones(count), spread**2]))
    forces = (30.0, WEIGHT - 30.0)
    raw = readings(truth, outputs(shoe, forces))
    old = calibration(shoe, drifted(truth, rng.uniform(0.2, 0.8, count)), covariance=covariance)
    _, change = rezero(old, shoe, raw, body(standing(forces)), largest=50.0, made_ns=9)
    assert np.abs(change[3:]).max() < 0.05 * np.abs(change[:3]).max()


def test_hanging_both_feet_read_zero(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray
) -> None:
    raw = readings(truth, outputs(shoe, (0.0, 0.0)))
    old = calibration(shoe, drifted(truth, drift))
    fresh, _ = rezero(old, shoe, raw, body(np.zeros(2)), largest=5.0, made_ns=9)
    wrenches = foot_wrenches(shoe, fresh.parameters.outputs(raw))
    np.testing.assert_allclose(wrenches, 0.0, atol=1e-9)


@pytest.mark.parametrize("foot", [0, 1])
def test_on_one_foot_the_other_reads_zero(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray, foot: int
) -> None:
    forces = (WEIGHT, 0.0) if foot == 0 else (0.0, WEIGHT)
    place = COPS[0] if foot == 0 else SUPPORT.right_to_left(COPS[1])
    raw = readings(truth, outputs(shoe, forces))
    old = calibration(shoe, drifted(truth, drift))
    fresh, _ = rezero(old, shoe, raw, body(place), largest=5.0, made_ns=9)
    wrenches = foot_wrenches(shoe, fresh.parameters.outputs(raw))
    expected = at_cop(np.array(WEIGHT), COPS[foot])
    np.testing.assert_allclose(wrenches[foot], expected, atol=1e-9)
    np.testing.assert_allclose(wrenches[1 - foot], 0.0, atol=1e-9)


def test_the_corrected_cop_is_the_one_that_counts(
    shoe: Shoe, truth: ChannelParameters, drift: FloatArray, rng: np.random.Generator
) -> None:
    corrections = tuple(
        CopCorrection(
            foot,
            x=np.concatenate([[0.3, 0.02, 0.01, 1e-3], rng.normal(0.0, 1e-5, count)]),
            y=np.concatenate([[0.3, 0.02, 0.01, 1e-3], rng.normal(0.0, 1e-5, count)]),
            cop_range=np.array([[-1.0, -1.0], [1.0, 1.0]]),
            output_range=np.array([np.full(count, -99.0), np.full(count, 99.0)]),
        )
        for foot in (0, 1)
        for count in [len(shoe.of_foot(foot))]
    )
    forces = (30.0, WEIGHT - 30.0)
    raw = readings(truth, outputs(shoe, forces))
    old = calibration(shoe, drifted(truth, drift), corrections)
    fresh, _ = rezero(old, shoe, raw, body(standing(forces)), largest=9.0, made_ns=9)
    measured = fresh.sensing(shoe).measure(raw)
    np.testing.assert_allclose(measured.total_grf, WEIGHT, atol=1e-6)
    np.testing.assert_allclose(measured.combined_cop(SUPPORT), standing(forces), atol=1e-8)


def test_what_is_no_drift_is_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    forces = (30.0, WEIGHT - 30.0)
    raw = readings(truth, outputs(shoe, forces))
    old = calibration(shoe, drifted(truth, np.full(len(shoe.names), 8.0)))
    with pytest.raises(RezeroError, match="calibrate anew"):
        rezero(old, shoe, raw, body(standing(forces)), largest=5.0, made_ns=9)


def test_a_cell_that_tells_nothing_is_refused(shoe: Shoe, truth: ChannelParameters) -> None:
    raw = readings(truth, outputs(shoe, (30.0, 24.0)))
    raw[0] = np.nan
    with pytest.raises(ShapeError):
        rezero(calibration(shoe, truth), shoe, raw, body(np.zeros(2)), largest=5.0, made_ns=9)
