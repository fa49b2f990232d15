from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.simulation.worlds import DEFAULT, PERFECT, World, changed, load_world
from shoecal_core.simulation.converter import GOOD, SATURATED, AdConverter
from shoecal_core.simulation.sampled_robot import draw_shoes

QUIET = changed(DEFAULT, cells__noise_std_n=0.0)


def converter(world: World, rules: object = QUIET, seed: int = 1) -> AdConverter:
    assert isinstance(rules, type(QUIET))
    shoes = draw_shoes(rules, world.shoe, seed)
    return AdConverter(world.shoe, rules, shoes, np.random.default_rng(seed))


@given(st.lists(st.floats(-20.0, 25.0), min_size=8, max_size=8), st.integers(0, 5))
def test_readings_follow_the_affine_law_to_half_a_step(forces: list[float], seed: int) -> None:
    nao = load_world("nao")
    parameters = draw_shoes(QUIET, nao.shoe, seed).parameters
    convert = converter(nao, seed=seed)
    readings = convert(np.array(forces))
    assert (readings.status == GOOD).all()
    found = parameters.outputs(readings.voltages)
    half_step = np.abs(parameters.gain) * convert.volts_per_count / 2.0
    assert (np.abs(found - forces) <= half_step * 1.001).all()
    assert readings.voltages == pytest.approx(readings.counts * convert.volts_per_count)


def test_a_step_is_the_range_over_its_bits(nao: World) -> None:
    convert = converter(nao, changed(QUIET, cells__converter_bits=12))
    assert convert.volts_per_count == pytest.approx(10.0 / 4096)
    assert np.unique(convert(np.tile(np.linspace(0, 9, 500)[:, None], 8)).counts[:, 0]).size < 500


def test_beyond_the_range_it_says_so(nao: World) -> None:
    readings = converter(nao, PERFECT)(np.array([1e3, -1e3, 10.0, 1e3, 10.0, 10.0, 10.0, 10.0]))
    assert readings.status.tolist() == [SATURATED, SATURATED, GOOD, SATURATED, *[GOOD] * 4]
    assert np.abs(readings.voltages).max() <= 5.0
    # The second cell is wired the other way round: pulled, it reads high.
    assert readings.voltages[:2] == pytest.approx([5.0, 5.0])


def test_an_inverted_cell_reads_the_other_way() -> None:
    odd = load_world("odd_biped")
    convert = converter(odd, PERFECT)
    rise = convert(np.full(9, 10.0)).voltages - convert(np.zeros(9)).voltages
    assert (np.sign(rise) == odd.shoe.polarity).all()
    assert np.sign(rise).sum() == 7


def test_noise_is_as_strong_as_asked_for(nao: World) -> None:
    rules = changed(DEFAULT, cells__noise_std_n=0.05)
    parameters = draw_shoes(rules, nao.shoe, 1).parameters
    outputs = parameters.outputs(converter(nao, rules)(np.full((20000, 8), 5.0)).voltages)
    assert outputs.std(axis=0) == pytest.approx(np.full(8, 0.05), rel=0.03)
    assert outputs.mean(axis=0) == pytest.approx(np.full(8, 5.0), abs=0.002)


def test_many_readings_are_single_ones_in_turn(nao: World) -> None:
    outputs = np.random.default_rng(1).uniform(0.0, 10.0, (5, 8))
    together, single = converter(nao, DEFAULT), converter(nao, DEFAULT)
    assert (together(outputs).counts == [single(row).counts for row in outputs]).all()


def test_an_asymmetric_range_saturates_at_its_own_ends(nao: World) -> None:
    channels = tuple(dataclasses.replace(one, lowest=0.0, highest=8.0) for one in nao.shoe.channels)
    shoe = dataclasses.replace(nao.shoe, channels=channels)
    convert = AdConverter(shoe, PERFECT, draw_shoes(PERFECT, shoe, 1), np.random.default_rng(1))
    readings = convert(np.array([1e4, -1e4] + [-1e4] * 6) * shoe.polarity)
    assert readings.voltages == pytest.approx([8.0, *[0.0] * 7], abs=1e-6)
