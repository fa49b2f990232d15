"""The baselines on regressions whose cause is known, and answers of others."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from blind.answers import Answer, Truth, seal
from blind.baselines import BASELINES, MOST_CAUSES
from blind.cases import Case
from blind.entries import OURS, compared, enter_folder, recorded
from blind.layout import Round
from blind.regression import Candidate, Regression
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.errors import ShoecalError

ROWS = 2000
LEAST = np.array([-1.0])


def _regression(sizes: dict[int, float], seed: int = 1) -> Regression:
    """White noise and, of some candidates, their columns at a size."""
    rng = np.random.default_rng(seed)
    base = rng.standard_normal((ROWS, 6))
    candidates = tuple(
        Candidate(effect, ("left",), rng.standard_normal((ROWS, 1)) + base[:, :1], LEAST, 1)
        for effect in EFFECTS
    )
    residuals = base @ rng.standard_normal(6) + rng.standard_normal(ROWS)
    for index, size in sizes.items():
        residuals = residuals + size * candidates[index].columns[:, 0]
    return Regression(base, residuals, candidates)


def _said(name: str, regression: Regression) -> dict[str, object]:
    said = BASELINES[name](regression)
    json.dumps(said, allow_nan=False)
    return said


def _causes(said: dict[str, object]) -> list[str]:
    causes = said["causes"]
    assert isinstance(causes, list)
    return [str(one["effect"]) for one in causes]


@pytest.mark.parametrize("name", BASELINES)
def test_white_noise_has_no_cause(name: str) -> None:
    assert _said(name, _regression({}))["verdict"] == "no_gap"


@pytest.mark.parametrize("name", BASELINES)
def test_the_only_cause_is_named(name: str) -> None:
    assert _causes(_said(name, _regression({3: 0.3}))) == [EFFECTS[3].identifier]


def test_f_tests_name_two_causes_the_larger_one_first() -> None:
    said = _said("F-tests", _regression({3: 0.3, 8: 0.5}))
    assert _causes(said) == [EFFECTS[8].identifier, EFFECTS[3].identifier]


def test_f_tests_name_no_more_than_so_many() -> None:
    sizes = {index: 0.3 + 0.1 * index for index in range(MOST_CAUSES + 2)}
    assert len(_causes(_said("F-tests", _regression(sizes)))) == MOST_CAUSES


@pytest.mark.parametrize("name", BASELINES)
def test_a_size_that_makes_no_sense_is_no_cause(name: str) -> None:
    assert EFFECTS[3].identifier not in _causes(_said(name, _regression({3: -1.5})))


def _answer(number: int) -> Answer:
    truth = Truth("latency", ("left",), {}, strength=3.0, seed=1)
    return Answer(
        number, "single", 7, 101, (0,), 1.0, imu=True, base="default", world={}, truths=(truth,)
    )


def test_answers_of_others_are_kept_once_and_compared(tmp_path: Path) -> None:
    place, theirs = Round(tmp_path / "round"), tmp_path / "theirs"
    answers = [_answer(1), _answer(2)]
    seal(place, answers)
    theirs.mkdir()
    for one in answers:
        place.recorded(one.number).mkdir(parents=True)
        (theirs / f"{place.recorded(one.number).name}.json").write_text(
            json.dumps(
                {
                    "verdict": "explained", "where": [], "ambiguity_set": [],
                    "causes": [
                        {"effect": "latency", "class": "timing", "location": ["left"],
                         "probability": 0.9, "size": {}}
                    ],
                }
            )
        )  # fmt: skip
    assert recorded(place) == [1, 2]
    assert enter_folder(place, "theirs", theirs) == 2
    with pytest.raises(ShoecalError, match="has been submitted"):
        enter_folder(place, "theirs", theirs)
    nothing = {"verdict": "no_gap", "causes": [], "ambiguity_set": [], "where": []}
    cases = [Case(one, 3.0, (0.0,), nothing) for one in answers]
    rows = {str(row["figure"]): row for row in compared(place, cases)}
    assert str(rows["found"][OURS]).startswith("0.00")
    assert str(rows["found"]["theirs"]).startswith("1.00")
    assert str(rows["right effect first, of single ones"]["theirs"]).startswith("1.00")


def test_an_answer_that_cannot_be_scored_is_refused_before_it_counts(tmp_path: Path) -> None:
    place = Round(tmp_path / "round")
    place.prepare()
    place.recorded(1).mkdir()
    (tmp_path / "set_0001.json").write_text('{"verdict": "explained"}')
    with pytest.raises(ShoecalError, match="needs ambiguity_set, causes, verdict, where"):
        enter_folder(place, "theirs", tmp_path)
    assert not place.ledger.exists()


def test_a_folder_without_answers_is_refused(tmp_path: Path) -> None:
    place = Round(tmp_path / "round")
    place.prepare()
    place.recorded(1).mkdir()
    with pytest.raises(ShoecalError, match="holds no answer"):
        enter_folder(place, "theirs", tmp_path)
