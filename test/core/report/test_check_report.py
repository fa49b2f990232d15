"""The report on a session before any calibration."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.report.pages import read
from core.report.sessions import swaying_session
from shoecal_core import cli
from shoecal_core.recording.session import Session
from shoecal_core.report.check_report import CheckReport, check_page, check_report
from shoecal_core.report.html import key_columns, render
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import align
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import LeftOut, Screening

HOSTILE = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def checked(session: Session) -> CheckReport:
    robot = load_robot(session.robot_yaml, session.shoe)
    runs = {one.run: session.read(one.run) for one in session.runs}
    kinematics = Kinematics(robot)
    aligned = {number: align(run, session.shoe, kinematics) for number, run in runs.items()}
    samples = {number: len(run.readings.time) for number, run in runs.items()}
    return CheckReport(
        session, robot, tuple(session.runs), runs, aligned, Screening(samples=samples), (), ()
    )


def test_a_fit_session(checked: CheckReport, tmp_path: Path) -> None:
    path = tmp_path / "check.html"
    check_report(path, checked)
    document = read(path.read_text(encoding="utf-8"))
    assert "PASS This session is fit for a calibration." in document.text
    assert f"Next: shoecal calibrate {checked.session.folder.name} --out" in document.text
    assert document.tags["details"] == 1
    assert "The recorded robot, its shoes and the floor are simulated." in document.text
    assert document.tags["svg"] == len(checked.runs)
    for number, run in checked.runs.items():
        assert f"run {number}" in document.text
        assert f"{run.readings.time[-1]:.1f} s" in document.text.replace("\N{NO-BREAK SPACE}", " ")
    for name in checked.session.shoe.names:
        assert name in document.text


def test_the_verdict_follows_problems_and_warnings(checked: CheckReport) -> None:
    warned = dataclasses.replace(checked, warnings=("a warning; see to it",))
    spoilt = dataclasses.replace(warned, problems=(f"run 2: {HOSTILE}; record it anew",))
    texts = [read(render(check_page(one))).text for one in (checked, warned, spoilt)]
    for text, level in zip(texts, ("PASS", "WARN", "FAIL"), strict=True):
        assert f" {level} " in text
    assert "a warning; see to it" in texts[1]
    assert texts[2].index("run 2:") < texts[2].index("a warning")
    assert "script" not in read(render(check_page(spoilt))).tags


def test_what_is_left_out_is_counted_and_drawn(checked: CheckReport) -> None:
    name = checked.session.shoe.names[3]
    lost = LeftOut(1, next(iter(Fault)), 30, 0.25, ((2.0, 5.0),), (name,))
    screening = dataclasses.replace(checked.screening, left_out=(lost,))
    page = check_page(dataclasses.replace(checked, screening=screening))
    text = read(render(page)).text.replace("\N{NO-BREAK SPACE}", " ")
    counted = sum(screening.samples.values())
    assert f"30 of {counted} samples do not count ({3000 / counted:.1f} %)" in text
    assert f"Faulty: {name}." in text


def test_channels_that_give_nothing_can_be_drawn(checked: CheckReport) -> None:
    readings = checked.runs[1].readings
    value = readings.value.copy()
    value[:, 0] = np.nan
    silent = dataclasses.replace(
        checked.runs[1], readings=dataclasses.replace(readings, value=value)
    )
    alone = {1: silent}
    content = dataclasses.replace(checked, runs=alone, entries=checked.entries[:1], aligned={})
    assert "–" in read(render(check_page(content))).text


def test_nothing_that_can_be_read(checked: CheckReport) -> None:
    empty = dataclasses.replace(
        checked, runs={}, entries=(), aligned={}, screening=Screening(), problems=("no run",)
    )
    assert "0 runs that can be read" in read(render(check_page(empty))).text


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    session = swaying_session(tmp_path / "recorded")
    report = tmp_path / "check.html"
    code = cli.main(["check", str(session.folder), "--report", str(report)])
    assert report.is_file()
    assert (code == 0) == ("FAIL" not in read(report.read_text(encoding="utf-8")).text[:400])
    capsys.readouterr()
    assert cli.main(["check", str(session.folder), "--report", str(tmp_path / "no" / "x")]) == 1
    assert "make it first" in capsys.readouterr().err


@pytest.mark.parametrize(("count", "columns"), [(0, 4), (2, 4), (5, 5), (7, 7), (8, 4), (9, 5)])
def test_key_figures_fill_their_rows(count: int, columns: int) -> None:
    assert key_columns(count) == columns


def test_fewer_key_figures_fit_beside_each_other_on_paper() -> None:
    assert [key_columns(count, 5) for count in (3, 5, 6, 7, 9)] == [4, 5, 4, 4, 5]
