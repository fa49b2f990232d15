"""A small round from beginning to end: drawn, sealed, simulated, diagnosed, scored."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest

from blind import motions
from blind.answers import read_answers, seal
from blind.composition import Mix, compose
from blind.generate import make_sets
from blind.layout import ROOT, Round
from blind.score import score
from blind.submit import Submission, submit
from shoecal_core.planning.motion_sets import MOTION_SETS, TEST, THOROUGH, PlannedRun, set_runs
from shoecal_core.recording.session import TRUTH, Session
from shoecal_core.robot.double_support import DoubleSupport

MOTIONS = 1
SHORT = (0, 1, 2, 5)
"""Of the thorough set: three runs to train, one to test."""


def _short(
    name: str, supports: Sequence[DoubleSupport], neutral: DoubleSupport
) -> tuple[PlannedRun, ...]:
    runs = set_runs(name, supports, neutral)
    return tuple(runs[index] for index in SHORT)


@pytest.mark.timeout(600)
def test_a_small_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motions, "POOL", tmp_path / "pool")
    # Few motions: the test is of the way, not of the diagnosis.
    monkeypatch.setattr(motions, "set_runs", _short)
    place = Round(tmp_path / "round")
    answers = [
        dataclasses.replace(one, order=tuple(range(len(SHORT))))
        for one in compose(5, Mix(1, 1, 0, 0), {MOTIONS: [30.0] * len(MOTION_SETS[THOROUGH])})
    ]
    motions.planned_set(MOTIONS)
    digest = seal(place, answers)
    # In this process: its motions are not those of the benchmark.
    make_sets(place, 1)

    for answer in read_answers(place):
        session = Session.open(place.recorded(answer.number))
        assert session.seed is None
        assert not (session.folder / TRUTH).exists()
        assert [entry.hint for entry in session.runs].count(TEST) == 1
        made = json.loads(place.made(answer.number).read_text())
        assert len(made["starts"]) == len(SHORT)
        assert made["cop_mm"] > 0.0
    recorded = [place.recorded(one.number).stat().st_mtime_ns for one in answers]
    make_sets(place, 1)
    assert recorded == [place.recorded(one.number).stat().st_mtime_ns for one in answers]

    submit(place, [Submission(one.number, place.recorded(one.number)) for one in answers], 2)
    for answer in answers:
        assert "verdict" in json.loads(place.diagnosis(answer.number).read_text())

    project = tmp_path / "project"
    (project / "docs" / "evidence").mkdir(parents=True)
    shutil.copy(ROOT / "docs" / "evidence" / "diagnosis.md", project / "docs" / "evidence")
    figures = score(place, 2, command="make blind", ablations=0, project=project)
    assert figures["as built"]["errors"].value in {0.0, None}
    assert figures["clean"]["errors"].value in {0.0, None}
    told = json.loads((project / "out" / "blind.json").read_text())
    assert set(told["figures"]) == set(figures)
    assert all(
        set(one) == {"value", "interval", "target", "met", "count"}
        for of in told["figures"].values()
        for one in of.values()
    )
    page = (project / "docs" / "evidence" / "diagnosis.md").read_text()
    assert digest in page
    assert (project / "docs" / "figures" / "blind-detection.svg").is_file()
