"""What a round holds, and what is drawn of its sets."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import yaml

from blind.answers import Answer
from blind.catalogue import EFFECTS, exactly, item
from blind.composition import BUILT, FULL, Mix, compose
from blind.draws import STRENGTHS, draw_location, draw_size, magnitude_of, own_gap, unit_sizes
from blind.laws import LAWS
from blind.noise import STEEPEST
from blind.unknown_laws import FUNCTIONS
from blind.unknowns import KINDS
from blind.world import AS_BUILT, write_reality
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.motion_sets import MOTION_SETS, THOROUGH
from shoecal_core.simulation.effects.registry import EFFECTS as SIMULATED
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workspace import config_dir

RUNS = MOTION_SETS[THOROUGH].runs
DURATIONS = {101: (30.0,) * len(RUNS), 102: (20.0,) * len(RUNS)}


@pytest.fixture(scope="module")
def full() -> list[Answer]:
    return compose(1, Mix.of(None), DURATIONS)


def test_a_full_round_has_enough_of_everything(full: list[Answer]) -> None:
    counts = Counter(one.category for one in full)
    assert counts == FULL
    assert sum(not one.as_built for one in full) / len(full) == pytest.approx(0.25, abs=0.1)


def test_numbers_tell_nothing(full: list[Answer]) -> None:
    assert [one.number for one in full] == list(range(1, len(full) + 1))
    clean = np.array([one.category == "clean" for one in full])
    halves = [part.mean() for part in np.array_split(clean, 4)]
    assert np.ptp(halves) < 0.3


def test_a_seed_draws_the_same_round_again_and_another_one_another(full: list[Answer]) -> None:
    assert compose(1, Mix.of(None), DURATIONS) == full
    assert compose(2, Mix.of(None), DURATIONS) != full


def test_effects_and_strengths_are_spread_evenly(full: list[Answer]) -> None:
    single = [one.truths[0] for one in full if one.category == "single"]
    effects = Counter(truth.effect for truth in single)
    assert set(effects) == set(EFFECTS)
    assert max(effects.values()) - min(effects.values()) <= 1
    strengths = Counter(truth.strength for truth in single)
    assert set(strengths) == set(STRENGTHS)
    assert max(strengths.values()) - min(strengths.values()) <= 8


def test_there_are_six_kinds_at_least_that_no_library_knows(full: list[Answer]) -> None:
    kinds = {one.foreign.kind for one in full if one.foreign is not None}
    assert kinds == {*KINDS, *FUNCTIONS}
    assert len(kinds) >= 6
    assert not {name.replace(" ", "_") for name in kinds} & set(EFFECTS)


def test_effects_with_a_drawn_law_have_a_seed_and_no_size_and_others_a_size(
    full: list[Answer],
) -> None:
    for truth in (truth for one in full for truth in one.truths):
        assert (truth.seed is not None) == (truth.effect in LAWS)
        assert truth.seed is None or set(truth.size) <= {"time"}


def test_robots_are_built_better_and_worse_and_noise_has_all_colours(full: list[Answer]) -> None:
    built = np.array([one.built for one in full if one.as_built])
    assert BUILT[0] <= built.min() < 0.7
    assert 2.0 < built.max() <= BUILT[1]
    assert {one.built for one in full if not one.as_built} == {1.0}
    assert np.ptp([one.slope for one in full]) > 0.8 * STEEPEST


@pytest.mark.parametrize("base", ["default", "other_laws"])
def test_as_built_errors_are_scaled_all_alike(base: str, tmp_path: Path) -> None:
    for built in (1.0, 2.0):
        write_reality(tmp_path / f"{built:g}.yaml", {}, base=base, built=built)
    one, two = (yaml.safe_load((tmp_path / name).read_text()) for name in ("1.yaml", "2.yaml"))
    for section, keys in AS_BUILT.items():
        for key in keys:
            np.testing.assert_allclose(
                _numbers(two[section][key]), 2.0 * _numbers(one[section][key])
            )
    assert one["joints"]["play_rad"] == {"all": 0.0045}


def _numbers(value: float | dict[str, float | list[float]]) -> FloatArray:
    rows = list(value.values()) if isinstance(value, dict) else [value]
    return np.hstack([np.asarray(row, dtype=np.float64) for row in rows])


def test_two_effects_are_two(full: list[Answer]) -> None:
    for one in full:
        if one.category == "double":
            assert len({exactly(truth.place) for truth in one.truths}) == 2


def test_a_small_round_has_the_same_mix() -> None:
    assert Mix.of(29) == Mix(9, 13, 2, 4)
    assert Mix.of(2) == Mix(1, 1, 1, 1)


def test_every_effect_drawn_is_simulated_and_all_others_are_known() -> None:
    assert set(SIMULATED) - set(EFFECTS) == {"zero_offset", "total_mass"}
    assert set(EFFECTS) < set(SIMULATED)


@pytest.mark.parametrize("effect", [one for one in EFFECTS if one not in LAWS])
def test_every_effect_drawn_can_be_read(effect: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    for kind in EFFECTS[effect].places:
        location = draw_location(effect, kind, rng)
        size = draw_size(effect, 0.004, rng)
        assert set(size) | {"time"} == set(EFFECTS[effect].units) | {"time"}
        listed = item(effect, location, {**size, **({"time": 4.0} if effect == "slip" else {})})
        file = tmp_path / "reality.yaml"
        run = {"run": 1} if effect == "slip" else {}
        file.write_text(yaml.safe_dump({"format": 1, "effects": [{**listed, **run}]}))
        assert load_reality(config_dir() / "realities" / "default.yaml", file).effects


def test_sizes_are_read_off_what_was_measured() -> None:
    for key, told in unit_sizes().items():
        if len(told["gap"]) > 1 and 1.6 < told["gap"][0] < told["gap"][1] < 30.0:
            for magnitude, gap in zip(told["magnitude"], told["gap"], strict=True):
                if told["gap"].index(gap) in {0, len(told["gap"]) - 1}:
                    assert magnitude_of(key, gap, 1e9) == pytest.approx(magnitude)
    assert own_gap(np.sqrt(2.0)) == pytest.approx(1.0)
