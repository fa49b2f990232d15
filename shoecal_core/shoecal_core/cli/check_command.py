"""`shoecal check SESSION`: what is in it, and is it fit for use."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from shoecal_core.cli.arguments import (
    add_force,
    add_settings,
    add_weight,
    require_folder,
    settings_of,
)
from shoecal_core.cli.assessment_table import expected_table
from shoecal_core.cli.screening_table import screening_table
from shoecal_core.cli.tables import new_table, verdict_line
from shoecal_core.cli.zeros_table import weight_json, weight_line, zeros_table
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import PartialError, ShoecalError
from shoecal_core.estimation.checks import missing_text
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.weight import weigh
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import RunEntry, Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import align
from shoecal_core.samples.zeros import Zero, zeros_json
from shoecal_core.screening.clocks import align_runs
from shoecal_core.screening.extract import stances_of, zeros_of
from shoecal_core.screening.result import Screening
from shoecal_core.screening.screen import screen
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import split_reason
from shoecal_core.workflows.calibrate import calibrate_session


class UnfitSessionError(PartialError):
    """A session that cannot be calibrated from as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of the recorded session")
    add_settings(parser, "weights and tolerances")
    parser.add_argument("--report", type=Path, metavar="FILE", help="also write an HTML report")
    add_weight(parser)
    add_force(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """List what is in every run, then calibrate: what `calibrate` refuses, this never passes."""
    if args.report is not None:
        require_folder(args.report)
    settings = settings_of(CalibrationSettings, args.settings, "calibration")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    session = Session.open(args.session, force=args.force)
    problems = [
        f"{path.name} was not finished: rescue it with `shoecal recover {path}`"
        for path in session.unfinished
    ] + ([missing_text(session.missing)] if session.missing else [])
    # A robot or shoe file that cannot be used is named itself, not as another file's hash.
    robot = load_robot(
        session.robot_yaml, session.shoe, urdf=session.robot_urdf, weight_kg=args.weight_kg
    )
    read = _Read(Kinematics(robot), session, settings, problems)
    screening = screen(
        read.runs, read.aligned, session.shoe, robot.weight, settings, read.time_offset
    )
    read.find_stances(screening)
    console.print(_table(session, read))
    if not read.runs:
        problems.append(f"{session.folder}: no run can be read; record some")
    problems += [found.reason for found in screening.findings if found.verdict == "FAIL"]
    warnings = [found.reason for found in screening.findings if found.verdict == "WARN"]
    calibration = _calibration(session, settings, tolerances, args.weight_kg, problems)
    zeros = zeros_json(session.shoe, read.zeros) if calibration is None else calibration.zeros
    weighed = weigh(
        session.shoe, {run: one.readings for run, one in read.aligned.items()}, read.zeros
    )
    console.print(weight_line(weighed, robot), soft_wrap=True)
    if zeros:
        console.print(zeros_table(zeros))
    if calibration is not None:
        console.print(expected_table(calibration.assessment))
        found = {reason: split_reason(reason, "WARN") for reason in calibration.calibration.reasons}
        levels = found.values() if calibration.calibration.verdict != "PASS" else ()
        problems += [text for level, text in levels if level == "FAIL"]
        warnings += [text for level, text in levels if level == "WARN" and text not in warnings]
    if screening.left_out:
        console.print(screening_table(screening))
    for verdict, lines in (("FAIL", problems), ("WARN", warnings)):
        for line in lines:
            console.print(verdict_line(verdict, line), soft_wrap=True)
    if args.report is not None:
        # Matplotlib takes a second to load, which most calls need not wait for.
        from shoecal_core.report.check_report import CheckReport, check_report  # noqa: PLC0415

        content = CheckReport(session, robot, tuple(read.entries), read.runs, read.aligned,
                              screening, tuple(problems), tuple(warnings), tuple(zeros),
                              weighed)  # fmt: skip
        check_report(args.report, content)
    figures = {
        "robot": session.robot,
        "shoe": session.shoe_name,
        "runs": [_figures(entry, read.runs[entry.run]) for entry in read.entries],
        "problems": problems,
        "warnings": warnings,
        "weight": weight_json(weighed, robot),
        "zeros": zeros,
        "screening": screening.to_json(),
        "assessment": None
        if calibration is None
        else calibration.assessment.to_json(calibration.data.shoe),
    }
    if problems:
        raise UnfitSessionError(
            f"{len(problems)} problem(s) in {session.folder}, listed above", figures
        )
    summary = "fit for use, with the warnings above" if warnings else "fit for use"
    console.print(verdict_line("WARN" if warnings else "PASS", summary))
    return figures


def _calibration(
    session: Session,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    weight_kg: float | None,
    problems: list[str],
) -> CalibrationOutcome | None:
    """What `calibrate` would find; None where it would refuse, which is a problem, or there is one.

    Zeros that change between runs do not make a session unfit: each run is judged with its own.
    """
    if problems:
        return None
    try:
        return calibrate_session(
            session, settings=settings, tolerances=tolerances, weight_kg=weight_kg, rezero=True
        )
    except ShoecalError as error:
        problems.append(str(error))
        return None


class _Read:
    """The runs that can be read; what is wrong with the others goes to the problems."""

    def __init__(
        self,
        kinematics: Kinematics,
        session: Session,
        settings: CalibrationSettings,
        problems: list[str],
    ) -> None:
        self.runs: dict[int, Run] = {}
        self.zeros: list[Zero] = []
        self._kinematics, self._shoe, self._problems = kinematics, session.shoe, problems
        for entry in session.runs:
            try:
                recorded = session.read(entry.run)
                align(recorded, session.shoe, kinematics)
                self.runs[entry.run] = recorded
            except ShoecalError as error:
                problems.append(str(error))
        self.entries = [entry for entry in session.runs if entry.run in self.runs]
        self.aligned, self.time_offset = align_runs(self.runs, session.shoe, kinematics, settings)

    def find_stances(self, screening: Screening) -> None:
        """See whether every run has stances to calibrate from."""
        for number, run in self.runs.items():
            try:
                aligned = self.aligned[number]
                self.zeros += zeros_of(run, aligned, self._shoe, self._kinematics)
                stances_of(run, aligned, self._shoe, self._kinematics, screening)
            except ShoecalError as error:
                self._problems.append(str(error))


def _table(session: Session, read: _Read) -> Table:
    table = new_table(f"{session.robot} on {session.shoe_name}")
    for name in ("run", "set", "motion", "dx dy dtheta", "s", "joints Hz", "readings Hz", "notes"):
        table.add_column(name)
    for entry in read.entries:
        table.add_row(*_cells(entry, read.runs[entry.run]))
    return table


def _figures(entry: RunEntry, run: Run) -> dict[str, object]:
    support = entry.info.support
    return {
        "run": entry.run,
        "set": entry.hint,
        "motion": entry.info.motion,
        "support": None if support is None else [support.dx, support.dy, support.dtheta],
        "duration_s": float(run.readings.time[-1] - run.readings.time[0]),
        "joints_hz": run.joints.rate_hz,
        "readings_hz": run.readings.rate_hz,
        "notes": list(run.notes),
    }


def _cells(entry: RunEntry, run: Run) -> list[str]:
    support = entry.info.support
    return [
        str(entry.run),
        entry.hint or "-",
        entry.info.motion,
        ("both feet in the air" if entry.info.hanging else "-")
        if support is None
        else f"{1e3 * support.dx:.0f} {1e3 * support.dy:.0f} mm {np.degrees(support.dtheta):.0f}°",
        f"{run.readings.time[-1] - run.readings.time[0]:.1f}",
        f"{run.joints.rate_hz:.0f}",
        f"{run.readings.rate_hz:.0f}",
        "; ".join(run.notes) or "-",
    ]
