"""What is answered of gaps of known size, with a known cause and without."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.diagnosis.drawn import Urn, part
from shoecal_core.diagnosis import answer as answer_module
from shoecal_core.diagnosis.answer import (
    EXPLAINED_FROM,
    SURELY,
    Answer,
    ambiguity_set,
    answer,
    confirmed,
    probabilities,
)
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import NamedHypothesis
from shoecal_core.diagnosis.scoring import Part
from shoecal_core.diagnosis.selection import Ranked, Selection
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.shrink import FORCE_AND_PLACE, excess
from shoecal_core.diagnosis.tempering import needed, temper
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP, GRF
from shoecal_core.recording.session import Session

SETTINGS = DiagnosisSettings()
TILT = {"floor_tilt": [0.03, 0.02]}
SURE = 1e5
"""Logarithm of probability that leaves no doubt of anything in the library."""


def nothing(unmodelled: float) -> Selection:
    """Nothing chosen; an unmodelled term as probable as given."""
    return Selection(None, (), (), unmodelled)


def found_in(workspace: Workspace, *labels: str, evidence: Sequence[float] = (SURE,)) -> Selection:
    """The first one chosen, and all as its alternatives."""
    parts: list[Part] = [part(workspace, label) for label in labels]
    rivals = tuple((one[0], log) for one, log in zip(parts, evidence, strict=True))
    return Selection(workspace.scorer.score(parts[:1]), (rivals,), (), -3.0)


def answered(workspace: Workspace, label: str) -> Answer:
    """With that as the explanation, and the robot as built as it leaves it."""
    found = found_in(workspace, label)
    return answer(workspace.at(found.stands(workspace.scorer, SETTINGS)), (), found, SETTINGS)


def test_a_gap_that_nothing_explains_is_unknown(urn: Urn) -> None:
    calm, leaning = (urn.draw(np.random.default_rng(2), truth) for truth in ({}, TILT))
    # A gap, but no evidence of anything; evidence, but no gap; both.
    assert answer(leaning, (), nothing(-3.0), SETTINGS).verdict == "no_gap"
    assert answer(calm, (), nothing(SURE), SETTINGS).verdict == "no_gap"
    assert answer(leaning, (), nothing(SURE), SETTINGS).verdict == "unknown"


def test_what_explains_a_gap_is_its_cause(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(2), TILT)
    said = answered(drawn, "floor_tilt")
    assert said.verdict == "explained"
    (cause,) = said.causes
    assert cause.effect == "floor_tilt"
    assert cause.probability == pytest.approx(1.0)
    assert cause.shrink.fraction > EXPLAINED_FROM
    other = answered(drawn, "link_com (Neck_link)")
    assert other.verdict == "partly_explained"


def test_what_test_runs_do_not_confirm_is_not_named(urn: Urn) -> None:
    drawn = urn.draw(np.random.default_rng(5), TILT)
    kept, words = confirmed(drawn, found_in(drawn, "floor_tilt"), SETTINGS)
    assert kept.chosen is not None
    assert words == ()
    assert kept.predicted[0] > needed(SETTINGS)
    left, words = confirmed(drawn, found_in(drawn, "link_com (Neck_link)"), SETTINGS)
    assert left.chosen is None
    assert words[0].startswith("link_com (Neck_link): ")
    assert words[0].endswith("test runs do not confirm it: not named")
    # Test runs without the tilt that the others had.
    own = drawn.signal_model.residuals.copy()
    calm = urn.draw(np.random.default_rng(5)).signal_model.residuals
    own[drawn.rows_of(drawn.test)] = calm[drawn.rows_of(drawn.test)]
    other = urn.showing(own)
    left, words = confirmed(other, found_in(other, "floor_tilt"), SETTINGS)
    assert left.chosen is None
    assert len(words) == 1


@pytest.mark.parametrize(("true", "named"), [(1.0, True), (0.4, False), (-1.0, False)])
def test_a_cause_must_take_what_it_says_on_test_runs(urn: Urn, true: float, named: bool) -> None:
    """Where the tilt of the test runs is another one than that of the others."""
    tilted, calm = (urn.draw(np.random.default_rng(5), truth) for truth in (TILT, {}))
    own, without = (one.signal_model.residuals for one in (tilted, calm))
    test = tilted.rows_of(tilted.test)[:, None]
    drawn = urn.showing(np.where(test, without + true * (own - without), own))
    left, words = confirmed(drawn, found_in(drawn, "floor_tilt"), SETTINGS)
    assert (left.chosen is not None) == named
    assert len(words) == (not named)


@pytest.mark.parametrize(("share", "named"), [(0.8, True), (0.2, False)])
def test_a_further_cause_is_probable_by_itself(urn: Urn, share: float, named: bool) -> None:
    """One that others explain as well is no second cause, however sure it is that one is there."""
    truth = {**TILT, "latency (left)": [0.06]}
    drawn = urn.draw(np.random.default_rng(5), truth)
    first, second, rival = (
        part(drawn, one) for one in ("floor_tilt", "latency (left)", "creep (left)")
    )
    counts = temper(SURE)
    alike = tuple(
        (one[0], SURE + math.log(probability) / counts)
        for one, probability in ((second, share), (rival, 1.0 - share))
    )
    chosen = drawn.scorer.score([first, second])
    alone = Ranked(drawn.scorer.score([first]), SURE, drawn.scorer.nothing)
    found = Selection(chosen, (((first[0], SURE),), alike), (alone,), -3.0)
    left, words = confirmed(drawn, found, SETTINGS)
    assert left.chosen is not None
    assert len(left.chosen.parts) == 1 + named
    assert len(words) == (not named)


def test_where_nothing_is_off_on_test_runs_nothing_is_named(urn: Urn) -> None:
    """What takes all of nearly nothing is no cause."""
    drawn = urn.draw(np.random.default_rng(5), TILT)
    calm = drawn.signal_model.residuals.copy()
    calm[drawn.rows_of(drawn.test)] *= 0.01
    quiet = urn.showing(calm)
    left, words = confirmed(quiet, found_in(quiet, "floor_tilt"), SETTINGS)
    assert left.chosen is None
    assert len(words) == 1


def test_the_next_one_is_named_where_test_runs_refute_the_first(
    urn: Urn, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = urn.draw(np.random.default_rng(5), TILT)
    true, wrong = (
        Ranked(drawn.scorer.score([one]), log, drawn.scorer.nothing)
        for one, log in (
            (part(drawn, "floor_tilt"), 30.0),
            (part(drawn, "link_com (Neck_link)"), SURE),
        )
    )
    monkeypatch.setattr(answer_module, "over_all_runs", lambda *_: [wrong, true])
    settings = replace(SETTINGS, causes_max=1, material_m=0.0)
    named, words = answer_module.first_confirmed(drawn, settings)
    assert named.chosen is not None
    assert named.chosen.parts[0][0] is true.part[0]
    assert len(words) == 1
    assert words[0].startswith(wrong.part[0].label)


def test_a_gap_of_the_force_alone_is_seen_where_the_cop_has_none(urn: Urn) -> None:
    """Of both together a CoP below its floor would hide it."""
    own = urn.draw(np.random.default_rng(8), {"span_drift (all)": [7e-5]}).signal_model.residuals
    off = own.copy()
    off[:, COP] *= 0.01
    drawn = urn.showing(off)
    rest = drawn.explained(None)[0]
    force, both = (excess(drawn, rest, drawn.test, part) for part in (GRF, FORCE_AND_PLACE))
    assert both < SURELY < force
    assert answer(drawn, (), nothing(-3.0), SETTINGS).verdict == "unknown"


def test_what_a_robot_as_built_may_have_is_not_named(urn: Urn) -> None:
    """However well it predicts: a run that was fitted is not predicted at all."""
    drawn = urn.draw(np.random.default_rng(5), TILT)
    hypothesis, form = part(drawn, "floor_tilt")
    once = replace(form, shape=replace(form.shape, run=drawn.train[0]))
    chosen = drawn.scorer.score([(hypothesis, once)])
    found = Selection(chosen, (((hypothesis, -1.0),),), (), -3.0)
    left, words = confirmed(drawn, found, SETTINGS)
    assert left.chosen is None
    assert "any robot may be built with" in words[0]
    sure = replace(found, alternatives=(((hypothesis, SURE),),))
    kept, words = confirmed(drawn, sure, SETTINGS)
    assert kept.chosen is chosen
    assert kept.predicted == (0.0,)
    assert words == ()


@pytest.mark.parametrize("predicted", [0.0, 6.0, -6.0])
def test_what_may_not_be_there_lowers_every_probability(urn: Urn, predicted: float) -> None:
    """Runs left out speak for all of them or for none."""
    labels = ("floor_tilt", "latency (left)", "low_pass (left)")
    found = found_in(urn.workspace, *labels, evidence=(30.0, 30.0, 10.0))
    told = probabilities(replace(found, predicted=(predicted,)), 0)
    counts = temper(30.0)
    weights = np.exp(counts * np.array([30.0, 30.0, 10.0, -predicted]))
    wanted = (weights / weights.sum())[:3]
    np.testing.assert_allclose([one.probability for one in told], wanted)


def test_a_set_holds_with_the_wanted_probability() -> None:
    ranking = tuple(
        NamedHypothesis("latency", (place,), share)
        for place, share in (("left", 0.6), ("right", 0.32), ("all", 0.04))
    )
    assert ambiguity_set(ranking, SETTINGS) == ranking[:2]


def test_who_asks_is_told_sizes_but_a_robot_as_built_is_not_accused(
    standard_session: Session,
) -> None:
    asked = ("payload", "latency", "total_mass")
    said = diagnose(standard_session, only=lambda effect, _place: effect in asked)
    assert {cause.effect for cause in said.causes} == {"payload", "latency"}
    for cause in said.causes:
        for one in cause.size.values():
            assert one.ci95[0] < one.value < one.ci95[1]
        assert np.isfinite(cause.shrink.fraction)
    assert any(line.startswith("total_mass: ") for line in said.cannot_detect)
    assert said.next_motion is None
    assert said.verdict == "no_gap"
    assert said.named == ()
    assert said.action is not None
    assert said.action.do.startswith("nothing")
