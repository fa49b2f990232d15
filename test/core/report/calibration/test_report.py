from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.report import samples
from core.report.pages import read
from core.robot import robots
from core.shoe import shoes
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.report.calibration.content import CalibrationReport, RunReport
from shoecal_core.report.calibration.report import (
    calibration_page,
    calibration_report,
    subtitle,
    verdict_of,
)
from shoecal_core.report.html import render
from shoecal_core.report.quantities import mean_error

HOSTILE = "<script>alert('$x$')</script> & \"b\""


def text_of(content: CalibrationReport) -> str:
    return read(render(calibration_page(content))).text


def spaced(text: str) -> str:
    return " ".join(text.split())


def test_a_whole_report(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    content = samples.content(shoes.shoe("nao_shoe"))
    calibration_report(path, content)
    html = path.read_text(encoding="utf-8")
    document = read(html)
    assert path.stat().st_size < 3_000_000
    # Two of accuracy, two maps, four a run, one of each run's feet.
    assert document.tags["svg"] == 2 + 2 + 5 * 5
    assert not re.search(r"https?:", html)
    assert all(link.startswith(("#", "data:image/")) for link in document.links)
    assert len(document.ids) == len(set(document.ids))
    for run in content.runs:
        assert f"Run {run.run} · {'test' if run.test else 'training'}" in document.text
    assert content.provenance[0] in document.text


def test_the_figures_told_are_those_computed(content: CalibrationReport, text: str) -> None:
    for stage in ("initial_guess", "self_calibration", "modelled"):
        for found in content.errors[stage].values():
            assert spaced(mean_error(found.grf, "N")) in text
            assert spaced(mean_error(found.cop, "mm", 1e3)) in text
    calibrated = content.errors["self_calibration"]["test"]
    for mae in calibrated.foot_cop:
        assert spaced(mean_error(mae, "mm", 1e3)) in text
    assert "x 60 mm, y −120 mm, yaw −22.9°" in text
    assert "61.2 s" in text
    assert "24.5 °C" in text


def test_the_same_content_is_the_same_bytes(small_html: str) -> None:
    again = samples.content(shoes.shoe("nao_shoe"), runs=1, truth=False)
    assert render(calibration_page(again)) == small_html


def test_key_figures_say_against_what(content: CalibrationReport, small: CalibrationReport) -> None:
    for one, reference in ((content, "truth"), (small, "model")):
        first, second, *_ = calibration_page(one).key_figures
        assert first.label == f"CoP error against the {reference}"
        assert second.label == f"GRF error against the {reference}"
        assert first.note.startswith(("test runs; initial guess: ", "training runs; initial"))


@pytest.mark.parametrize(
    ("level", "meaning"),
    [("PASS", "may be used."), ("WARN", "with care"), ("FAIL", "must not be used")],
)
def test_verdict_and_cures(small: CalibrationReport, level: str, meaning: str) -> None:
    reasons = (f"{level}: a cell is dead: check its wiring", "without a level")
    verdict = verdict_of(replace(small.calibration, verdict=level, reasons=reasons))
    assert meaning in verdict.meaning
    assert [reason.level for reason in verdict.reasons] == [level, level]
    assert verdict.reasons[0].text == "a cell is dead: check its wiring"


def test_what_is_missing_is_said(small: CalibrationReport, small_html: str) -> None:
    assert small.judged == "train"
    text = read(small_html).text
    assert "no truth here" in text
    assert "against the truth" not in text
    assert "No run was kept for a test" in text


def test_a_calibration_that_was_not_found_here(small: CalibrationReport) -> None:
    given = replace(small.calibration, covariance=None, source="manual")
    text = text_of(replace(small, stages=None, assessed=None, calibration=given))
    assert "manual calibration" in text
    assert "without uncertainties" in text
    assert "How it was found" not in text
    assert "Expected errors and observability" not in text


def test_simulated_clocks_name_no_day(small: CalibrationReport) -> None:
    assert "2026-09-21" in subtitle(small)
    early = replace(small.calibration, made_ns=5 * 10**9)
    assert "1970" not in subtitle(replace(small, calibration=early))


def test_hostile_names_do_no_harm() -> None:
    shoe = shoes.shoe("odd_shoe")
    channels = tuple(replace(one, name=one.name + HOSTILE) for one in shoe.channels)
    shoe = replace(shoe, name=HOSTILE, unit=HOSTILE + "\x07", channels=channels)
    robot = replace(robots.load("odd_biped"), name=HOSTILE)
    content = replace(
        samples.content(shoe, robot=robot, runs=1, reasons=(HOSTILE,)),
        provenance=(HOSTILE,),
        timing={HOSTILE: 1.0},
    )
    document = read(render(calibration_page(content)))
    assert "script" not in document.tags
    assert document.text.count(HOSTILE) > 10


def test_walking_has_many_stances(small: CalibrationReport) -> None:
    run = small.runs[0]
    one = run.stances[0]
    later = replace(one, stance=replace(one.stance, loaded=(True, False)))
    walk = replace(run, stances=(one, later))
    text = text_of(replace(small, runs=(walk,)))
    assert "2 stances" in text
    assert "CoP between the feet" not in text
    assert len(walk.series("measured").time) == 2 * len(one.stance.time) + 1


def test_content_that_does_not_fit(content: CalibrationReport) -> None:
    run = content.runs[0]
    with pytest.raises(ShoecalError, match="at least one run"):
        replace(content, runs=())
    with pytest.raises(ShoecalError, match="other channels than shoe"):
        replace(content, shoe=shoes.shoe("odd_shoe"))
    blind = replace(run, stances=(replace(run.stances[0], truth=None),))
    with pytest.raises(ShoecalError, match="all or none"):
        replace(content, runs=(blind, *content.runs[1:]))
    with pytest.raises(ShoecalError, match="one run and of one set"):
        RunReport((), run.snapshot_time, run.snapshot_angles)
    with pytest.raises(ShoecalError, match="one run and of one set"):
        replace(run, stances=(*run.stances, *content.runs[1].stances))
    with pytest.raises(ShapeError, match="snapshot_angles"):
        replace(run, snapshot_time=np.zeros(2))
