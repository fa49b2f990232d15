from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.manual.benches import (
    PERFECT,
    floor_wrench,
    nao_shoe,
    odd_shoe,
    read_shoe,
    some_law,
    without,
)
from shoecal_core.errors import ShoecalError
from shoecal_core.manual.assembly import assembled, shoe_wrench
from shoecal_core.manual.loads import Load
from shoecal_core.manual.measurements import Measurements
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, foot_wrenches
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes


def wrenches(
    shoe: Shoe, loads: Measurements, parameters: ChannelParameters
) -> dict[Load, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """What each load is measured as."""
    found = {}
    for entry in loads.entries:
        readings = np.zeros(len(shoe.names))
        readings[shoe.of_foot(entry.load.foot)] = entry.mean
        found[entry.load] = foot_wrenches(shoe, parameters.outputs(readings))[entry.load.foot]
    return found


def test_the_bare_shoe_weighs_its_plates() -> None:
    shoe = nao_shoe()
    for foot, plates in enumerate(shoe.plates):
        wrench = shoe_wrench(shoe, foot)
        masses = np.array([plates.mass_above, plates.mass_below])
        places = np.array([plates.com_above, plates.com_below])[:, :2]
        assert wrench[0] == pytest.approx(masses.sum() * GRAVITY)
        np.testing.assert_allclose(cop(wrench, 0.0), masses @ places / masses.sum())


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_whatever_assembling_shifted_the_wrenches_come_out_right(seed: int) -> None:
    shoe = nao_shoe()
    law = some_law(shoe)
    rng = np.random.default_rng(seed)
    shifted = ChannelParameters(law.gain, law.offset + rng.normal(0.0, 1.0, len(law.offset)))
    # The assembled shoe reads by the shifted law; the cells were measured before.
    loads = read_shoe(shoe, shifted, (2.0,))
    found, _, shift = assembled(loads, law, None)
    for load, wrench in wrenches(shoe, loads, found).items():
        np.testing.assert_allclose(wrench, floor_wrench(shoe, load), atol=1e-9)
    # The smallest shift that does it: none in the pattern that makes no wrench.
    assert np.linalg.norm(shift) <= np.linalg.norm(shifted.offset - law.offset) + 1e-12


def test_the_convention_is_that_of_the_physics(tmp_path: Path) -> None:
    """A perfect shoe on the rig is measured as the formula for the expected wrench says."""
    for shoe in (nao_shoe(), odd_shoe(tmp_path)):
        drawn = draw_shoes(PERFECT, shoe, 1)
        rig = LoadingRig(shoe, PERFECT, drawn, np.random.default_rng(1))
        for foot in (0, 1):
            holes = shoe.holes[foot]
            assert holes is not None
            for load in (Load(foot, "", 0.0), Load(foot, "a1", 1.0), Load(foot, "d3", 4.0)):
                place = holes.position(load.place) if load.place else np.zeros(2)
                volts = rig.readings(load.mass, foot, place, count=20).voltages.mean(axis=0)
                measured = foot_wrenches(shoe, drawn.parameters.outputs(volts))[foot]
                expected = floor_wrench(shoe, load)
                assert measured[0] == pytest.approx(expected[0], abs=2e-3)
                np.testing.assert_allclose(cop(measured, 0.5), cop(expected, 0.5), atol=1e-4)


def test_the_covariance_is_what_repetition_shows() -> None:
    shoe = nao_shoe()
    law = some_law(shoe)
    count = len(shoe.names)
    rng = np.random.default_rng(1)
    factor = rng.normal(0.0, 1e-3, (2 * count, 2 * count))
    covariance = factor @ factor.T
    loads = read_shoe(shoe, law, (2.0,))
    _, found, _ = assembled(loads, law, covariance)
    assert found is not None
    draws = []
    for _ in range(1500):
        error = factor @ rng.standard_normal(2 * count)
        off = ChannelParameters(law.gain + error[:count], law.offset + error[count:])
        entries = tuple(
            dataclasses.replace(
                entry, mean=entry.mean + entry.noise * rng.standard_normal(len(entry.mean))
            )
            if not entry.load.place
            else entry
            for entry in loads.entries
        )
        fixed, *_ = assembled(dataclasses.replace(loads, entries=entries), off, None)
        draws.append(np.concatenate((fixed.gain, fixed.offset)))
    spread = np.cov(np.array(draws).T)
    np.testing.assert_allclose(np.diag(spread), np.diag(found), rtol=0.2)
    scale = np.sqrt(np.diag(found))
    assert np.abs((spread - found) / np.outer(scale, scale)).max() < 0.15


def test_scatter_that_nobody_told_leaves_the_covariance_unknown() -> None:
    shoe = nao_shoe()
    law = some_law(shoe)
    loads = read_shoe(shoe, law, (2.0,))
    blind = dataclasses.replace(
        loads,
        entries=tuple(
            dataclasses.replace(entry, std=np.full(4, np.nan)) for entry in loads.entries
        ),
    )
    assert assembled(blind, law, np.eye(16))[1] is None
    assert assembled(loads, law, None)[1] is None


def test_a_bare_shoe_that_was_not_read() -> None:
    shoe = nao_shoe()
    law = some_law(shoe)
    loads = without(read_shoe(shoe, law, (2.0,)), Load(1, "", 0.0))
    with pytest.raises(ShoecalError, match="reading of the bare right shoe"):
        assembled(loads, law, None)
