"""What cannot be done is refused before any work: one line, and no step of progress before it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from core.cli.conftest import ROBOT, SHOE, Run
from core.cli.test_faulty_sessions import rewritten
from shoecal_core.recording.run import Run as Recorded


def refusal(shoecal: Run, *words: object) -> str:
    """The one line of an error."""
    code, out, error = shoecal(*words)
    assert code == 1
    assert not out
    (line,) = error.splitlines()
    return line


def test_a_session_that_exists(shoecal: Run, simulated: Path) -> None:
    line = refusal(shoecal, "simulate", ROBOT, SHOE, "--out", simulated)
    assert f"{simulated}: exists already" in line
    assert "name another folder" in line


def test_an_import_into_a_session_that_exists(
    shoecal: Run, simulated: Path, tmp_path: Path
) -> None:
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("format: 1\n")
    line = refusal(shoecal, "import", "csv", mapping, tmp_path, "--out", simulated)
    assert f"{simulated}: exists already" in line


def test_a_manual_calibration_that_the_method_would_ignore(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    words = ["calibrate", simulated, "--manual", calibrated, "--out", tmp_path / "c.yaml"]
    line = refusal(shoecal, *words, "--method", "paper")
    assert "method: paper fits gains and offsets alone" in line
    assert "the manual calibration would be ignored" in line
    assert "calibrate with the method joint" in line


def test_a_manual_calibration_with_a_walk(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    def walking(run: Recorded) -> Recorded:
        if run.info.run != 2:
            return run
        return replace(run, info=replace(run.info, motion="walking", support=None))

    session = rewritten(simulated, tmp_path / "session", walking)
    words = ["calibrate", session, "--manual", calibrated, "--out", tmp_path / "c.yaml"]
    line = refusal(shoecal, *words)
    assert "run 2 is of a walk, whose fit would ignore the manual calibration" in line
    assert "without --manual, or from runs in double support alone (--train, --test)" in line


def test_a_plan_into_a_file(shoecal: Run, tmp_path: Path) -> None:
    out = tmp_path / "plan"
    out.touch()
    code, _, error = shoecal("plan", ROBOT, "--shoe", SHOE, "--out", out)
    assert code == 1
    (line,) = error.splitlines()
    assert str(out) in line


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "cells: {position_error_m: {left/toee: [0.001, 0.0]}}",
            (
                "cells.position_error_m: there is no channel 'left/toee' (did you mean 'left/toe'? "
                "there are: "
            ),
        ),
        (
            "effects: [{effect: hysteresis, location: [left/toee], fraction: 0.1}]",
            "effects[0].location: there is no channel 'left/toee' (did you mean 'left/toe'? ",
        ),
        (
            "effects: [{effect: payload, location: [bas], mass_kg: 0.1}]",
            "effects[0].location: there is no link 'bas' (",
        ),
    ],
)
def test_a_reality_of_other_shoes(shoecal: Run, tmp_path: Path, text: str, told: str) -> None:
    reality = tmp_path / "reality.yaml"
    reality.write_text(f"format: 1\n{text}\n")
    words = ("--reality", reality, "--out", tmp_path / "session")
    line = refusal(shoecal, "simulate", ROBOT, SHOE, *words)
    assert f"{reality}: {told}" in line
    assert not (tmp_path / "session").exists()


@pytest.mark.parametrize(
    ("only", "told"),
    [
        ("latency:lft", "no place of latency named 'lft' (did you mean 'left'? there are: left, "),
        (
            "crosstalk:left/toe,right/b",
            "no place of crosstalk named 'left/toe,right/b' (did you mean ",
        ),
        ("inertia:left", "inertia has no place: ask for 'inertia', without a colon"),
    ],
)
def test_a_place_that_there_is_not(shoecal: Run, simulated: Path, only: str, told: str) -> None:
    assert told in refusal(shoecal, "diagnose", simulated, "--only", only)


def test_a_history_whose_report_has_no_folder(shoecal: Run, calibrated: Path) -> None:
    report = calibrated.parent / "none" / "report.html"
    assert "make it first" in refusal(shoecal, "history", calibrated, "--report", report)
