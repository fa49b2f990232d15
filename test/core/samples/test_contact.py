"""Feet in the air: joints and load have to agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.samples.contact import find_contact
from shoecal_core.shoe.shoe_file import load_shoe

CELLS, ANKLES = shoes.shoe("nao_shoe"), load_shoe(shoes.ROOT / "config/shoes/reemc.yaml")
"""Without and with data sheets."""
WEIGHT = 673.0
COUNT = 600


def readings(shares: FloatArray, zeros: tuple[float, float] = (-74.0, -51.0)) -> FloatArray:
    """Of ankle sensors with zeros [N] whose feet carry shares (T, 2) of the weight."""
    found = np.zeros((len(shares), len(ANKLES.names)))
    for foot, channel in enumerate(("left/fz", "right/fz")):
        found[:, ANKLES.index(channel)] = 1.1 * WEIGHT * shares[:, foot] + zeros[foot]
    return found


def steps() -> tuple[FloatArray, FloatArray]:
    """(T, 2) shares and heights: each foot in turn lifted for a fifth of the time."""
    phase = np.linspace(0.0, 6.0, COUNT) % 1.0
    left = np.interp(phase, (0.0, 0.2, 0.3, 0.5, 0.6, 0.9, 1.0), (1, 1, 0.5, 0, 0, 0.5, 1))
    height = 0.03 * np.stack((left == 0.0, left == 1.0), axis=1)
    return np.stack((left, 1.0 - left), axis=1), height


def clearance(height: FloatArray) -> FloatArray:
    return height - height[:, ::-1]


def test_feet_that_are_lifted_and_carry_nothing_are_in_the_air() -> None:
    shares, height = steps()
    found = find_contact(ANKLES, readings(shares), clearance(height), WEIGHT)
    np.testing.assert_array_equal(found.air, shares == 0.0)
    np.testing.assert_allclose(found.load, 1.1 * shares, atol=1e-9)


@pytest.mark.parametrize("least", [0.1, 0.2])
def test_a_foot_that_carries_a_tenth_is_never_in_the_air(least: float) -> None:
    """Whatever the range of its readings: nothing lifts it."""
    shares, _ = steps()
    shares = least + (1.0 - 2.0 * least) * shares
    rng = np.random.default_rng(1)
    wobble = 0.002 * rng.standard_normal((COUNT, 2))
    found = find_contact(ANKLES, readings(shares), clearance(wobble), WEIGHT)
    assert not found.air.any()
    assert np.isnan(found.load).all()


def test_joints_alone_do_not_lift_a_foot() -> None:
    """A base pose that is wrong seems to lift feet which share the weight."""
    _, height = steps()
    shares = np.full((COUNT, 2), 0.5)
    found = find_contact(ANKLES, readings(shares), clearance(height), WEIGHT)
    assert not found.air.any()


def test_load_alone_does_not_either() -> None:
    shares, height = steps()
    found = find_contact(ANKLES, readings(shares), clearance(0.0 * height), WEIGHT)
    assert not found.air.any()


def test_cells_without_data_sheets_are_in_the_air_at_their_least() -> None:
    shares, height = steps()
    cells = CELLS.polarity * shares[:, CELLS.foot] * 0.4 + np.linspace(-0.3, 0.3, 8)
    found = find_contact(CELLS, cells, clearance(height), WEIGHT)
    np.testing.assert_array_equal(found.air, shares == 0.0)
    swapped = CELLS.polarity * (1.0 - shares)[:, CELLS.foot] * 0.4
    assert not find_contact(CELLS, swapped, clearance(height), WEIGHT).air.any()


def test_which_foot_is_loaded_needs_to_know_how_the_cells_are_wired() -> None:
    unknown = replace(CELLS, channels=(replace(CELLS.channels[0], polarity=0), *CELLS.channels[1:]))
    with pytest.raises(ShoecalError, match="give the polarity of the left foot"):
        find_contact(unknown, np.zeros((COUNT, 8)), np.zeros((COUNT, 2)), WEIGHT)
