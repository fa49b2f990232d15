"""Readings to GRF and CoP of both feet, loaded or not, corrected or not."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.correction import CopCorrection, corrected_channels
from shoecal_core.shoe.sensing import MINIMUM_FORCE, Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, foot_wrenches, weight_below

ROOT = Path(__file__).parents[3]
SHOES = [
    load_shoe(ROOT / path)
    for path in ("config/shoes/nao_shoe.yaml", "config/shoes/reemc.yaml",
                 "test/data/shoes/odd_shoe.yaml")
]  # fmt: skip
SUPPORT = DoubleSupport(0.03, -0.11, 0.4)


def some_parameters(shoe: Shoe, seed: int = 0) -> ChannelParameters:
    rng = np.random.default_rng(seed)
    count = len(shoe.channels)
    return ChannelParameters(
        rng.uniform(15.0, 30.0, count) * rng.choice([-1.0, 1.0], count),
        rng.uniform(-9.0, 9.0, count),
    )


def outputs_for(shoe: Shoe, wrenches: FloatArray) -> FloatArray:
    """(n,) outputs under which each foot's floor wrench is the given one (2, 3)."""
    outputs = np.zeros(len(shoe.channels))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        felt = wrenches[foot] - weight_below(shoe)[foot]
        outputs[own] = np.linalg.pinv(shoe.columns[own].T) @ felt
    return outputs


def readings_for(parameters: ChannelParameters, outputs: FloatArray) -> FloatArray:
    """Readings that a channel's law turns into the given outputs."""
    return (outputs - parameters.offset) / parameters.gain


def correction(shoe: Shoe, foot: int, **changes: FloatArray) -> CopCorrection:
    """A correction of 1 mm in x and -2 mm in y, trained everywhere."""
    count = len(shoe.of_foot(foot))
    parts = {
        "x": np.array([0.0, 0.0, 0.0, 1e-3, *np.zeros(count)]),
        "y": np.array([0.0, 0.0, 0.0, -2e-3, *np.zeros(count)]),
        "cop_range": np.array([[-1.0, -1.0], [1.0, 1.0]]),
        "output_range": np.array([[-1e3] * count, [1e3] * count]),
    } | changes
    return CopCorrection(foot=foot, **parts)


@given(
    st.floats(5.0, 60.0), st.floats(5.0, 60.0),
    st.tuples(*[st.floats(-0.05, 0.08)] * 4).map(np.array),
)  # fmt: skip
def test_known_loads_at_known_places(left: float, right: float, places: FloatArray) -> None:
    for name in shoes.NAMES:
        shoe = shoes.shoe(name)
        parameters = some_parameters(shoe)
        force, place = np.array([left, right]), places.reshape(2, 2)
        readings = readings_for(parameters, outputs_for(shoe, at_cop(force, place)))
        measured = Sensing(shoe, parameters).measure(readings)
        np.testing.assert_allclose(measured.grf, force, rtol=1e-10)
        np.testing.assert_allclose(measured.cop, place, atol=1e-10)
        np.testing.assert_allclose(measured.total_grf, left + right, rtol=1e-10)
        seen = np.stack((place[0], SUPPORT.right_to_left(place[1])))
        np.testing.assert_allclose(
            measured.combined_cop(SUPPORT), force @ seen / force.sum(), atol=1e-10
        )
        assert not measured.extrapolating.any()


def test_a_hanging_foot_reads_zero_and_has_no_cop(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    place = np.array([0.02, 0.01])
    standing = at_cop(np.array([50.0, 0.0]), np.stack((place, place)))
    outputs = outputs_for(shoe, standing)
    # The lower plate pulls: together the cells read its weight, upside down.
    pull = outputs[shoe.of_foot(1)].sum()
    assert pull == pytest.approx(-shoe.plates[1].mass_below * 9.80665)
    measured = Sensing(shoe, parameters).measure(readings_for(parameters, outputs))
    assert abs(measured.grf[1]) < 1e-12
    assert np.isnan(measured.cop[1]).all()
    np.testing.assert_allclose(measured.combined_cop(SUPPORT), place, atol=1e-12)


@pytest.mark.parametrize("foot", [0, 1])
@pytest.mark.parametrize("force", [-20.0, 0.0, 0.99 * MINIMUM_FORCE])
def test_an_unloaded_foot_does_not_move_the_combined_cop(
    shoe: Shoe, foot: int, force: float
) -> None:
    parameters = some_parameters(shoe)
    places = np.array([[0.03, -0.01], [0.01, 0.02]])
    loads = np.array([40.0, 40.0])
    loads[foot] = force
    readings = readings_for(parameters, outputs_for(shoe, at_cop(loads, places)))
    measured = Sensing(shoe, parameters).measure(readings)
    other = (places[0], SUPPORT.right_to_left(places[1]))[1 - foot]
    assert np.isnan(measured.cop[foot]).all()
    np.testing.assert_allclose(measured.grf[foot], force, atol=1e-10)
    np.testing.assert_allclose(measured.combined_cop(SUPPORT), other, atol=1e-10)


def test_no_loaded_foot_no_combined_cop(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    readings = readings_for(parameters, outputs_for(shoe, np.zeros((2, 3))))
    measured = Sensing(shoe, parameters).measure(np.stack((readings, readings)))
    assert np.isnan(measured.combined_cop(SUPPORT)).all()


def test_a_missing_reading_spoils_its_foot_and_the_sum_but_no_other_sample(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    loads = at_cop(np.array([30.0, 25.0]), np.array([[0.02, 0.0], [0.01, 0.01]]))
    readings = np.tile(readings_for(parameters, outputs_for(shoe, loads)), (3, 1))
    readings[1, shoe.of_foot(0)[1]] = np.nan
    measured = Sensing(shoe, parameters, [correction(shoe, 0)]).measure(readings)
    assert np.isnan(measured.grf[1, 0])
    assert np.isnan(measured.cop[1, 0]).all()
    np.testing.assert_allclose(measured.grf[1, 1], 25.0)
    # Half of the load unseen: any CoP of both feet would be wrong.
    assert np.isnan(measured.combined_cop(SUPPORT)[1]).all()
    assert np.isnan(measured.total_grf[1])
    assert np.isfinite(measured.combined_cop(SUPPORT)[[0, 2]]).all()


def drawn_correction(shoe: Shoe, foot: int, rng: np.random.Generator) -> CopCorrection:
    count = len(corrected_channels(shoe, foot))
    return CopCorrection(
        foot,
        rng.normal(0.0, 0.05, 4 + count),
        rng.normal(0.0, 0.05, 4 + count),
        np.sort(rng.normal(0.0, 0.05, (2, 2)), axis=0),
        np.sort(rng.normal(10.0, 20.0, (2, count)), axis=0),
    )


@given(st.integers(0, 2**32 - 1), st.sampled_from(SHOES), st.integers(0, 3), st.booleans())
def test_one_instant_is_what_the_batch_gives(
    seed: int, shoe: Shoe, corrected: int, gone: bool
) -> None:
    rng = np.random.default_rng(seed)
    count = len(shoe.names)
    law = ChannelParameters(rng.normal(0.0, 10.0, count), rng.normal(0.0, 3.0, count))
    corrections = [drawn_correction(shoe, foot, rng) for foot in (0, 1) if corrected & (1 + foot)]
    sensing = Sensing(shoe, law, corrections)
    readings = rng.normal(0.0, 2.0, count)
    if gone:
        readings[rng.integers(count)] = math.nan
    measured = sensing.measure(readings)
    for foot, found in enumerate(sensing.measure_instant(readings.tolist())):
        np.testing.assert_allclose(found.force, measured.grf[foot], rtol=1e-9, atol=1e-9)
        expected = measured.cop[foot]
        if found.cop is None:
            assert not np.isfinite(expected).all()
            continue
        np.testing.assert_allclose(found.cop, expected, rtol=1e-9, atol=1e-9)
        assert found.extrapolating == measured.extrapolating[foot]


def test_batches_equal_single_samples(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    readings = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 5, len(shoe.channels)))
    sensing = Sensing(shoe, parameters, [correction(shoe, 1)])
    whole = sensing.measure(readings)
    for index in np.ndindex(2, 5):
        one = sensing.measure(readings[index])
        np.testing.assert_allclose(whole.grf[index], one.grf, rtol=1e-12)
        np.testing.assert_allclose(whole.cop[index], one.cop, rtol=1e-9)
        np.testing.assert_array_equal(whole.extrapolating[index], one.extrapolating)
        np.testing.assert_allclose(
            whole.combined_cop(SUPPORT)[index], one.combined_cop(SUPPORT), rtol=1e-9
        )


@pytest.mark.parametrize("feet", [(0,), (1,), (0, 1)])
def test_corrections_move_their_own_foot_and_its_share_of_the_sum(
    shoe: Shoe, feet: tuple[int, ...]
) -> None:
    parameters = some_parameters(shoe)
    force = np.array([20.0, 30.0])
    place = np.array([[0.02, 0.0], [0.01, 0.01]])
    readings = readings_for(parameters, outputs_for(shoe, at_cop(force, place)))
    plain = Sensing(shoe, parameters).measure(readings)
    moved = Sensing(shoe, parameters, [correction(shoe, foot) for foot in feet]).measure(readings)
    step = np.array([1e-3, -2e-3])
    np.testing.assert_array_equal(moved.grf, plain.grf)
    both = np.zeros(2)
    for foot in (0, 1):
        shift = step if foot in feet else np.zeros(2)
        np.testing.assert_allclose(moved.cop[foot] - plain.cop[foot], shift, atol=1e-14)
        turned = shift if foot == 0 else SUPPORT.rotation @ shift
        both += turned * force[foot] / force.sum()
    found = moved.combined_cop(SUPPORT) - plain.combined_cop(SUPPORT)
    np.testing.assert_allclose(found, both, atol=1e-14)


def test_extrapolation_is_told_for_the_foot_that_does_it(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    place = np.array([[0.02, 0.0], [0.01, 0.01]])
    readings = readings_for(parameters, outputs_for(shoe, at_cop(np.array([20.0, 30.0]), place)))
    narrow = correction(shoe, 1, cop_range=np.array([[0.0, 0.0], [0.009, 0.02]]))
    sensing = Sensing(shoe, parameters, [correction(shoe, 0), narrow])
    assert sensing.measure(readings).extrapolating.tolist() == [False, True]


def test_what_does_not_belong_to_the_shoe_is_refused(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    with pytest.raises(ShapeError, match="readings"):
        Sensing(shoe, parameters).measure(np.zeros(len(shoe.channels) + 1))
    short = ChannelParameters(parameters.gain[1:], parameters.offset[1:])
    with pytest.raises(ShapeError, match="gain"):
        Sensing(shoe, short)
    with pytest.raises(ShoecalError, match="left foot has two"):
        Sensing(shoe, parameters, [correction(shoe, 0), correction(shoe, 0)])
    other = shoes.shoe("odd_shoe" if shoe.name == "nao_shoe" else "nao_shoe")
    with pytest.raises(ShapeError, match="correction of the right foot"):
        Sensing(shoe, parameters, [correction(other, 1)])


def test_measuring_leaves_the_readings_alone(shoe: Shoe) -> None:
    readings = np.random.default_rng(3).uniform(-1.0, 1.0, (5, len(shoe.channels)))
    before = readings.copy()
    Sensing(shoe, some_parameters(shoe), [correction(shoe, 0)]).measure(readings)
    np.testing.assert_array_equal(readings, before)


def test_the_wrench_of_a_foot_is_its_grf_at_its_cop(shoe: Shoe) -> None:
    parameters = some_parameters(shoe)
    force, place = np.array([20.0, 30.0]), np.array([[0.02, 0.0], [0.01, 0.01]])
    readings = readings_for(parameters, outputs_for(shoe, at_cop(force, place)))
    measured = Sensing(shoe, parameters).measure(readings)
    np.testing.assert_allclose(
        at_cop(measured.grf, measured.cop),
        foot_wrenches(shoe, parameters.outputs(readings)),
        atol=1e-12,
    )
