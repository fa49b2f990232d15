"""Zeros of feet in the air: found, stated with an interval, applied."""

from __future__ import annotations

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.zeros import (
    EDGE_S,
    data_sheet,
    with_own_zeros,
    zeros_json,
    zeros_of_run,
)
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters, foot_wrenches

CELLS, ANKLES = shoes.shoe("nao_shoe"), load_shoe(shoes.ROOT / "config/shoes/reemc.yaml")
TIME = np.arange(0.0, 20.0, 0.02)
SWING = (TIME % 2.0 > 1.0) & (TIME % 2.0 < 1.6)
AIR = np.stack((SWING, np.zeros_like(SWING)), axis=1)
ZEROS = np.array([3.0, -5.0, -74.0, 1.0, -2.0])


def swings(rng: np.random.Generator, accelerated: float = 10.0) -> FloatArray:
    """Readings of a left ankle whose foot swings, with an inertial force [N] in each swing."""
    found = rng.standard_normal((len(TIME), 10))
    found[:, :5] += ZEROS
    found[:, 2] += np.where(SWING, accelerated * np.sin(2 * np.pi * (TIME % 2.0 - 1.0) / 0.6), 700)
    return found


def test_a_swinging_foot_shows_its_zero_within_the_stated_interval() -> None:
    (zero,) = zeros_of_run(3, TIME, swings(np.random.default_rng(2)), AIR)
    (figures,) = zeros_json(ANKLES, [zero])
    assert (figures["run"], figures["foot"]) == (3, "left")
    assert figures["fz_n"] == pytest.approx(-74.0, abs=1.0)
    low, high = figures["ci95"]
    assert low < -74.0 < high
    assert high - low < 10.0
    np.testing.assert_allclose(zero.reading[:5], ZEROS, atol=1.0)


def test_edges_of_the_air_are_cut() -> None:
    readings = np.zeros((len(TIME), 10))
    leaving = SWING & (TIME % 2.0 < 1.0 + 0.9 * EDGE_S)
    readings[leaving, 2] = 300.0
    (zero,) = zeros_of_run(1, TIME, readings, AIR)
    assert zero.readings[:, 2].max() == 0.0


def test_what_recurs_in_every_swing_does_not_average_out() -> None:
    """Ten times the swings do not make the zero ten times as sure."""
    rng = np.random.default_rng(4)
    many = np.tile(swings(rng, 40.0), (10, 1))
    time = np.asarray(np.arange(len(many)) * 0.02, dtype=np.float64)
    law = data_sheet(ANKLES, 0)
    assert law is not None
    (few,) = zeros_of_run(1, TIME, many[: len(TIME)], AIR)
    (more,) = zeros_of_run(1, time, many, np.tile(AIR, (10, 1)))
    assert more.force(ANKLES, law)[1] > 0.8 * few.force(ANKLES, law)[1]


def test_a_foot_that_hangs_too_short_has_no_zero() -> None:
    air = AIR & (TIME % 2.0 < 1.1)[:, None]
    assert zeros_of_run(1, TIME, swings(np.random.default_rng(1)), air) == []


@pytest.mark.parametrize("shoe", [CELLS, ANKLES], ids=["cells", "ankles"])
def test_own_zeros_make_a_foot_in_the_air_read_nothing(shoe: object) -> None:
    assert isinstance(shoe, type(CELLS))
    rng = np.random.default_rng(6)
    count = len(shoe.names)
    true = ChannelParameters(shoe.polarity * rng.uniform(0.8, 1.2, count), np.zeros(count))
    wrong = ChannelParameters(true.gain, rng.normal(0.0, 20.0, count))
    below = GRAVITY * shoe.plates[0].mass_below
    own = shoe.of_foot(0)
    # Parts below the channels pull at them.
    hanging = np.zeros((len(TIME), count))
    pull = np.linalg.pinv(shoe.columns[own].T) @ (
        -below * np.array([1.0, shoe.plates[0].com_below[1], -shoe.plates[0].com_below[0]])
    )
    hanging[:, own] = pull / true.gain[own]
    zeros = zeros_of_run(1, TIME, hanging, AIR)
    found = with_own_zeros(shoe, wrong, zeros)
    left, right = foot_wrenches(shoe, found.outputs(hanging[0]))
    np.testing.assert_allclose(left, 0.0, atol=1e-9)
    np.testing.assert_array_equal(found.offset[shoe.of_foot(1)], wrong.offset[shoe.of_foot(1)])
    # Loads are then right, too: only offsets were wrong.
    loaded = hanging[0].copy()
    loaded[own] += 30.0 / true.gain[own]
    difference = foot_wrenches(shoe, found.outputs(loaded))[0] - left
    expected = 30.0 * shoe.columns[own].sum(axis=0)
    np.testing.assert_allclose(difference, expected, atol=1e-9)
    assert right.shape == (3,)


def test_without_data_sheets_zeros_are_told_by_the_calibration() -> None:
    hanging = np.full((len(TIME), 8), 0.2)
    zeros = zeros_of_run(1, TIME, hanging, AIR)
    assert zeros_json(CELLS, zeros) == []
    parameters = ChannelParameters(10.0 * np.ones(8), np.full(8, -1.0))
    (figures,) = zeros_json(CELLS, zeros, parameters)
    below = GRAVITY * CELLS.plates[0].mass_below
    assert figures["fz_n"] == pytest.approx(4.0 + below)
    assert figures["left_n"] == figures["fz_n"]
