"""What is selected of sessions in which the truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, part, remade
from shoecal_core.diagnosis.hypotheses import Hypothesis
from shoecal_core.diagnosis.selection import (
    Ranked,
    Selection,
    material,
    over_all_runs,
    rank,
    select,
)
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.tempering import needed
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import CLOSURE, COP

SETTINGS = DiagnosisSettings()
TRUTHS: dict[str, Sequence[float]] = {
    "joint_offset (LHipRoll)": [0.02],
    "latency (left)": [0.08],
    "floor_tilt": [0.02, 0.012],
    "zero_drift (left)": [0.003],
    # A loop that runs the other way round.
    "hysteresis (left/front_left)": [-0.15],
}


def test_an_urn_s_sums_are_those_of_its_residuals(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(0), {"floor_tilt": [0.01, 0.0]})
    made = remade(drawn).products
    np.testing.assert_allclose(drawn.sums.products, made, rtol=1e-9, atol=1e-9 * made.max())


@pytest.mark.parametrize("seed", range(4))
def test_of_noise_nothing_is_selected(urn: Urn, seed: int) -> None:
    found = select(urn.draw(np.random.default_rng(seed)), SETTINGS)
    assert found.chosen is None
    assert found.unmodelled < needed(SETTINGS)


@pytest.mark.parametrize("label", TRUTHS)
def test_one_effect_is_found(urn: Urn, label: str) -> None:
    rng = np.random.default_rng(len(label))
    found = select(urn.draw(rng, {label: TRUTHS[label]}), SETTINGS)
    assert found.chosen is not None
    assert len(found.chosen.parts) == 1
    first = [one.label for one, _ in found.alternatives[0][:3]]
    assert label in first


def test_of_two_effects_each_part_that_is_named_is_needed(urn: Urn) -> None:
    pair = ("latency (left)", "joint_offset (LHipRoll)")
    drawn = urn.draw(np.random.default_rng(2), {label: TRUTHS[label] for label in pair})
    found = select(drawn, SETTINGS)
    assert found.chosen is not None
    assert_needed(drawn, found)


def test_two_effects_are_found_each_for_what_it_is(urn: Urn) -> None:
    pair = {"joint_offset (LHipRoll)": [0.02], "floor_tilt": [0.02, -0.02]}
    drawn = urn.draw(np.random.default_rng(5), pair)
    found = select(drawn, SETTINGS)
    assert found.chosen is not None
    assert {one.label for one, _ in found.chosen.parts} == {*pair}


def assert_needed(drawn: Workspace, found: Selection) -> None:
    """Without any of the parts the data are far less probable."""
    assert found.chosen is not None
    for index in range(len(found.chosen.parts)):
        others = [part for at, part in enumerate(found.chosen.parts) if at != index]
        without = drawn.scorer.score(others).evidence
        assert found.chosen.evidence - without >= needed(SETTINGS)


def test_of_three_causes_as_many_are_named_as_may_be(urn: Urn) -> None:
    three = ("joint_offset (LHipRoll)", "latency (left)", "floor_tilt")
    drawn = urn.draw(np.random.default_rng(3), {label: TRUTHS[label] for label in three})
    found = select(drawn, replace(SETTINGS, causes_max=2))
    assert found.chosen is not None
    assert len(found.chosen.parts) <= 2
    assert_needed(drawn, found)


def test_exact_twins_are_equally_probable_and_others_are_not(urn: Urn) -> None:
    true, twin = "cell_position (left/front_left)", "crosstalk (left/rear_left, left/front_left)"
    # From the receiver's place to the donor's: what crosstalk does to the CoP.
    shoe = urn.workspace.signal_model.samples.shoe
    places = {
        name: urn.workspace.signal_model.wiring.columns[shoe.names.index(name)]
        for name in shoe.names
    }
    away = places["left/rear_left"] - places["left/front_left"]
    size = 0.2 * np.array([-away[2], away[1]])
    drawn = urn.draw(np.random.default_rng(5), {true: size.tolist()})
    singles = {label: drawn.scorer.score([part(drawn, label)]).evidence for label in (true, twin)}
    other = drawn.scorer.score([part(drawn, "cell_position (left/rear_left)")]).evidence
    assert abs(singles[true] - singles[twin]) < 8.0
    assert min(singles.values()) > other


def test_what_shows_on_runs_left_out_alone_matters(urn: Urn) -> None:
    """A drift is a part of zeros and gains while they are fitted, and not any more later."""
    drawn = urn.draw(np.random.default_rng(6), {"zero_drift (left)": [0.003]})
    scored = drawn.scorer.score([part(drawn, "zero_drift (left)")])
    added = drawn.calibrated(drawn.added(scored))
    sizes = [
        float(np.sqrt((added[drawn.rows_of(runs)][:, COP] ** 2).sum(axis=1).mean()))
        for runs in (drawn.train, drawn.test)
    ]
    assert sizes[1] > 1.2 * sizes[0]
    between = replace(SETTINGS, material_m=0.5 * sum(sizes))
    assert material(drawn, scored, between)
    assert not material(replace(drawn, test=()), scored, between)


def test_what_is_sure_but_too_small_to_matter_is_left_out(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(5), {"floor_tilt": [0.01, 0.006]})
    strict = replace(SETTINGS, material_m=1.0)
    assert select(drawn, strict).chosen is None


def test_a_slip_that_only_the_legs_show_is_evident(urn: Urn) -> None:
    _, form = part(urn.workspace, "slip (left)")
    columns = urn.workspace.catalogue.columns[list(form.columns)]
    slipped = np.zeros_like(columns[0])
    slipped[:, CLOSURE] = 0.01 * columns[0][:, CLOSURE]
    healthy = urn.draw(np.random.default_rng(7)).signal_model.residuals
    drawn = urn.showing(healthy + slipped)
    found = {one.part[0].label: one for one in rank(drawn, None)}
    assert found["slip (left)"].log > needed(SETTINGS)


def test_runs_left_out_count_like_those_that_were_fitted(urn: Urn) -> None:
    """By the chain rule: what was fitted predicts them as well as what is true does."""
    truth = "floor_tilt"
    drawn = urn.draw(np.random.default_rng(8), {truth: [0.012, 0.008]})
    ranked = {one.part[0].label: one for one in over_all_runs(drawn, None)}
    assert ranked[truth].predicted > 0.0
    assert ranked[truth].total == max(one.total for one in ranked.values())
    # Without them, and of what happened in one run, nothing is said.
    alone = replace(drawn, test=())
    assert all(one.total == one.log for one in over_all_runs(alone, None))
    bound = [one for one in ranked.values() if one.part[1].shape.run is not None]
    assert all(one.predicted == 0.0 for one in bound)


def test_the_most_probable_by_all_runs_is_chosen(urn: Urn) -> None:
    """Not the one that is by the fitted runs alone."""
    drawn = urn.draw(np.random.default_rng(9), {"floor_tilt": [0.02, 0.012]})
    first, second = (one for one in rank(drawn, None)[:2])
    singles = [replace(first, log=30.0), replace(second, log=20.0)]
    assert chosen(drawn, singles) is first.part[0]
    singles = [replace(second, log=20.0, predicted=11.0), replace(first, log=30.0)]
    assert chosen(drawn, singles) is second.part[0]


def test_runs_left_out_count_for_further_causes_too(urn: Urn) -> None:
    """They say of a second cause, beside the first, what they say of one by itself."""
    drawn = urn.draw(
        np.random.default_rng(8), {"floor_tilt": [0.02, 0.012], "latency (left)": [0.08]}
    )
    first = drawn.scorer.score([part(drawn, "floor_tilt")])
    ranked = over_all_runs(drawn, first)
    # Twins at this place, as far as this draw can say.
    assert ranked[0].part[0].label in {"latency (left)", "low_pass (left)"}
    both = drawn.predicted(ranked[0].scored, bounded=False)
    assert ranked[0].predicted == both - drawn.predicted(first, bounded=False)
    assert ranked[0].predicted > 0.0


def chosen(drawn: Workspace, singles: Sequence[Ranked]) -> Hypothesis:
    found = select(drawn, replace(SETTINGS, causes_max=1, material_m=0.0), singles)
    assert found.chosen is not None
    return found.chosen.parts[0][0]
