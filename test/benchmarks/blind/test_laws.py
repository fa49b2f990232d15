"""Laws that are drawn: what each of them is, whatever was drawn, and how large."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from blind.answers import PERFECT, Answer, Truth
from blind.catalogue import EFFECTS
from blind.draws import LIMITS, draw_location, own_gap, unit_floor
from blind.felt import Felt
from blind.gap import gap_of_change
from blind.laws import LAWS, channels_of, drawn_law
from blind.sizing import as_shown, sized
from blind.unknown_laws import FUNCTIONS, unknown_law
from population import nao
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.wrench import columns_in_left

RATE_HZ, RUN_S, RUNS, WEIGHT_N = 25.0, 20.0, 4, 60.0
CELL = ("left/front_left",)
SEEDS = range(6)


def _felt() -> Felt:
    """Loads that go round in four runs, the last of which is to test."""
    shoe = nao()[1]
    count = round(RATE_HZ * RUN_S)
    since = np.arange(count) / RATE_HZ
    rng = np.random.default_rng(1)
    forces = []
    for _ in range(RUNS):
        turns = rng.uniform(0.1, 0.3, 8)[:, None] * 2.0 * np.pi * since + rng.uniform(0, 6, (8, 1))
        share = 1.0 + 0.8 * np.sin(turns.T)
        forces.append(WEIGHT_N * share / share.sum(axis=1, keepdims=True))
    columns = columns_in_left(shoe, DoubleSupport(0.0, -0.1, 0.0))
    return Felt(
        run=np.repeat(np.arange(RUNS), count),
        time=np.concatenate([since + 1.2 * RUN_S * one for one in range(RUNS)]),
        since=np.tile(since, RUNS),
        forces=np.concatenate(forces),
        speeds=rng.standard_normal((RUNS * count, 5)),
        shoe=shoe,
        columns=np.tile(columns, (RUNS * count, 1, 1)),
        training=np.repeat(np.arange(RUNS) < RUNS - 1, count),
    )


FELT = _felt()


def _cell(effect: str, seed: int, size: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """(T,) what a cell felt, and what it shows at a share of the law's largest size."""
    law = drawn_law(FELT, effect, CELL, seed)
    (channel,) = channels_of(FELT, CELL)
    shown = law.shown(size * law.most)
    others = np.delete(shown - FELT.forces, channel, axis=1)
    assert not others.any()
    return FELT.forces[:, channel], shown[:, channel]


@pytest.mark.parametrize("effect", LAWS)
def test_a_seed_draws_the_same_law_again_and_another_one_another(effect: str) -> None:
    for kind in EFFECTS[effect].places:
        place = draw_location(effect, kind, np.random.default_rng(3))
        one, same, other = (drawn_law(FELT, effect, place, seed).shown(0.1) for seed in (4, 4, 5))
        np.testing.assert_array_equal(one, same)
        assert np.abs(one - other).max() > 1e-6


@pytest.mark.parametrize("effect", LAWS)
def test_without_size_nothing_is_shown(effect: str) -> None:
    if effect == "saturation":
        pytest.skip("its knee is at the largest load")
    place = draw_location(effect, EFFECTS[effect].places[0], np.random.default_rng(3))
    np.testing.assert_allclose(drawn_law(FELT, effect, place, 4).shown(0.0), FELT.forces)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", ["nonlinearity", "saturation"])
def test_a_law_of_the_load_alone_is_monotone_at_any_size(effect: str, seed: int) -> None:
    for size in (0.1, 1.0):
        felt, shown = _cell(effect, seed, size)
        assert np.diff(shown[np.argsort(felt)]).min() > -1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_a_saturated_cell_shows_all_loads_below_and_never_more_than_it_feels(seed: int) -> None:
    felt, shown = _cell("saturation", seed, 0.5)
    knee = (1.0 - 0.5 * 0.9) * felt.max()
    np.testing.assert_allclose(shown[felt < knee], felt[felt < knee])
    assert (shown <= felt + 1e-9).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_hysteresis_depends_on_the_way_and_its_loop_is_as_wide_as_its_size(seed: int) -> None:
    law = drawn_law(FELT, "hysteresis", CELL, seed)
    (channel,) = channels_of(FELT, CELL)
    felt, shown = FELT.forces[:, channel], law.shown(0.02)[:, channel]
    rising = np.gradient(felt) > 0.0
    assert (shown - felt)[rising].mean() < 0.0 < (shown - felt)[~rising].mean()
    assert np.abs(shown - felt).max() <= 0.02 * felt.max() * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_creep_never_exceeds_what_its_size_says(seed: int) -> None:
    felt, shown = _cell("creep", seed)
    assert (shown >= felt - 1e-9).all()
    assert (shown - felt).max() <= 0.5 * felt.max()


@pytest.mark.parametrize("seed", SEEDS)
def test_drifts_start_at_nothing_and_move_slowly(seed: int) -> None:
    felt, shown = _cell("zero_drift", seed)
    drift = shown - felt
    assert drift[0] == pytest.approx(0.0, abs=1e-9)
    inside = np.diff(FELT.run) == 0
    assert np.abs(np.diff(drift)[inside]).max() < 0.02 * np.abs(drift).max()


@pytest.mark.parametrize("effect", ["latency", "low_pass"])
@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_late_is_late_by_its_size_in_the_mean(effect: str, seed: int) -> None:
    size = 0.08
    shown = drawn_law(FELT, effect, ("all",), seed).shown(size)
    rates = np.concatenate(
        [np.gradient(FELT.forces[part], 1.0 / RATE_HZ, axis=0) for part in FELT.runs]
    )
    settled = FELT.since > 1.0
    change, rate = (shown - FELT.forces)[settled], rates[settled]
    assert -np.sum(change * rate) / np.sum(rate**2) == pytest.approx(size, rel=0.15)


def test_a_stuck_cell_is_itself_before_its_onset() -> None:
    onset = 30.0
    law = drawn_law(FELT, "stuck_cell", CELL, 4, onset)
    (channel,) = channels_of(FELT, CELL)
    shown, before = law.shown(1.0)[:, channel], FELT.time < onset
    np.testing.assert_array_equal(shown[before], FELT.forces[before, channel])
    late = FELT.time > onset + 5.0
    assert np.ptp(shown[late]) < 0.2 * np.ptp(FELT.forces[late, channel])


@pytest.mark.parametrize("kind", FUNCTIONS)
def test_an_unknown_law_changes_one_foot_and_is_drawn_the_same_again(kind: str) -> None:
    one, same = (unknown_law(FELT, kind, 7).shown(0.1) for _ in range(2))
    np.testing.assert_array_equal(one, same)
    changed = np.flatnonzero((one - FELT.forces).any(axis=0))
    assert len(set(FELT.shoe.foot[changed].tolist())) == 1


@pytest.mark.parametrize("effect", LAWS)
def test_laws_are_as_large_as_was_asked_for(effect: str) -> None:
    place = draw_location(effect, EFFECTS[effect].places[0], np.random.default_rng(3))
    law = drawn_law(FELT, effect, place, 4)
    found = sized(law, FELT, 3.0)
    own = gap_of_change(FELT, found.forces - FELT.forces).largest(unit_floor())
    assert found.size == law.most or own == pytest.approx(own_gap(3.0), rel=0.1)


def test_two_drawn_effects_act_one_after_the_other_each_with_its_own_strength() -> None:
    truths = (
        Truth("zero_drift", CELL, {}, strength=3.0, seed=1),
        Truth("floor_tilt", (), {"about_x": 0.01}, strength=3.0),
        Truth("latency", ("all",), {}, strength=2.0, seed=2),
    )
    answer = Answer(1, "double", 7, 101, (0,), 1.0, imu=True, base=PERFECT, world={}, truths=truths)
    shown, sizes = as_shown(answer, FELT)
    assert len(sizes) == 2
    first = drawn_law(FELT, "zero_drift", CELL, 1).shown(sizes[0])
    between = dataclasses.replace(FELT, forces=first)
    second = drawn_law(between, "latency", ("all",), 2).shown(sizes[1])
    np.testing.assert_allclose(shown.forces, second)
    own = gap_of_change(FELT, first - FELT.forces).largest(unit_floor())
    assert own == pytest.approx(own_gap(3.0), rel=0.1)


def test_what_gains_and_offsets_can_be_makes_no_gap() -> None:
    change = 0.01 * FELT.forces * np.arange(8) + 0.1 * np.arange(8)
    gap = gap_of_change(FELT, change)
    assert gap.cop_mm < 1e-6
    assert gap.grf_n < 1e-6


def test_white_noise_makes_the_gap_that_normal_numbers_have() -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.1, FELT.forces.shape)
    assert gap_of_change(FELT, noise).grf_n == pytest.approx(
        0.1 * np.sqrt(8.0 * 2.0 / np.pi), rel=0.15
    )


def test_an_effect_has_a_law_that_is_drawn_or_a_size_that_is() -> None:
    assert not set(LAWS) & set(LIMITS)
    assert set(LAWS) | set(LIMITS) | {"swapped_cells"} == set(EFFECTS)
