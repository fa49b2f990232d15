"""What is selected of sessions in which the truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, hypothesis, remade
from shoecal_core.diagnosis.selection import Found, select
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace

SETTINGS = DiagnosisSettings()
TRUTHS: dict[str, Sequence[float]] = {
    "cell_position (right/front_left)": [0.004, -0.003],
    "latency (left)": [0.08],
    "floor_tilt": [0.01, 0.006],
    "payload (base_link)": [0.15],
}


def test_an_urn_s_sums_are_those_of_its_residuals(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(0), {"floor_tilt": [0.01, 0.0]})
    np.testing.assert_allclose(drawn.sums.products, remade(drawn), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_of_noise_nothing_is_selected(urn: Urn, seed: int) -> None:
    found = select(urn.draw(np.random.default_rng(seed)), SETTINGS)
    assert found.chosen is None
    assert found.alternatives == ()


@pytest.mark.parametrize("label", TRUTHS)
def test_one_effect_is_found(urn: Urn, label: str) -> None:
    rng = np.random.default_rng(len(label))
    found = select(urn.draw(rng, {label: TRUTHS[label]}), SETTINGS)
    assert found.chosen is not None
    assert len(found.chosen.parts) == 1
    first = [one.label for one, _ in found.alternatives[0][:3]]
    assert label in first


def test_of_two_effects_each_part_that_is_named_is_needed(urn: Urn) -> None:
    pair = ("latency (left)", "cell_position (right/front_left)")
    drawn = urn.draw(np.random.default_rng(2), {label: TRUTHS[label] for label in pair})
    found = select(drawn, SETTINGS)
    assert found.chosen is not None
    assert_needed(drawn, found)


def test_two_effects_are_found_each_for_what_it_is(urn: Urn) -> None:
    pair = {"foot_placement (left)": [0.004, -0.004, 0.03], "floor_tilt": [0.02, -0.02]}
    drawn = urn.draw(np.random.default_rng(5), pair)
    found = select(drawn, SETTINGS)
    assert found.chosen is not None
    assert {one.label for one, _ in found.chosen.parts} == {*pair}


def test_a_mixture_that_looks_most_like_a_third_effect_is_taken_apart(urn: Urn) -> None:
    """By itself each of the two explains less than something that is not there."""
    pair = {"crosstalk (left/front_right, left/rear_left)": [0.12],
            "joint_offset (LAnkleRoll)": [-0.014]}  # fmt: skip
    drawn = urn.draw(np.random.default_rng(1), pair)
    found = select(drawn, SETTINGS)
    assert found.singles[0].parts[0][0].label not in pair
    assert found.chosen is not None
    assert {one.label for one, _ in found.chosen.parts} == {*pair}


def assert_needed(drawn: Workspace, found: Found) -> None:
    """Without any of the parts the data are far less probable."""
    assert found.chosen is not None
    for index in range(len(found.chosen.parts)):
        others = [part for at, part in enumerate(found.chosen.parts) if at != index]
        without = drawn.scorer.score(others).evidence
        assert found.chosen.evidence - without >= SETTINGS.evidence_min


def test_of_three_causes_as_many_are_named_as_may_be(urn: Urn) -> None:
    three = ("cell_position (right/front_left)", "payload (base_link)", "floor_tilt")
    drawn = urn.draw(np.random.default_rng(3), {label: TRUTHS[label] for label in three})
    found = select(drawn, replace(SETTINGS, causes_max=2))
    assert found.chosen is not None
    assert len(found.chosen.parts) <= 2
    assert_needed(drawn, found)


def test_exact_twins_are_equally_probable_and_others_are_not(urn: Urn) -> None:
    true, twin = "cell_position (left/front_left)", "crosstalk (left/rear_left, left/front_left)"
    # From the receiver's place to the donor's: what crosstalk does to the CoP.
    shoe = urn.workspace.scene.samples.shoe
    places = {
        name: urn.workspace.scene.wiring.columns[shoe.names.index(name)] for name in shoe.names
    }
    away = places["left/rear_left"] - places["left/front_left"]
    size = 0.05 * np.array([-away[2], away[1]])
    drawn = urn.draw(np.random.default_rng(4), {true: size.tolist()})
    singles = {
        label: drawn.scorer.best_form(hypothesis(drawn, label)).evidence for label in (true, twin)
    }
    assert abs(singles[true] - singles[twin]) < 10.0
    assert singles[true] > SETTINGS.evidence_min


def test_what_is_sure_but_too_small_to_matter_is_left_out(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(5), {"floor_tilt": [0.01, 0.006]})
    strict = replace(SETTINGS, material=1e6)
    assert select(drawn, strict).chosen is None
