"""`shoecal check SESSION …`: what is in it, and is it fit for use."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from shoecal_core.cli.arguments import (
    add_force,
    add_settings,
    add_weight,
    settings_of,
)
from shoecal_core.cli.many_sessions import (
    EACH,
    EXPECTED,
    Ended,
    Figures,
    SessionJob,
    add_sessions,
    add_spread,
    named_sessions,
    output_files,
    over_sessions,
)
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import TEXT, new_table, of_page, print_table, verdict_line
from shoecal_core.cli.weight import weight_json, weight_line
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import PartialError
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import RunEntry, Session
from shoecal_core.report.calibration.assessment_tables import expected_table
from shoecal_core.report.next_step import after_check
from shoecal_core.report.recorded_tables import left_out_table, zeros_table
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.workflows.check import check_session


class UnfitSessionError(PartialError):
    """A session that cannot be calibrated from as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    add_sessions(parser)
    add_settings(parser, "weights and tolerances")
    parser.add_argument(
        "--report", type=Path, metavar="FILE", help=f"also write an HTML report; {EACH}"
    )
    add_weight(parser)
    add_force(parser)
    add_spread(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Check one session, or many at once."""
    settings = settings_of(CalibrationSettings, args.settings, "calibration")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    jobs = [
        SessionJob(
            session,
            partial(
                _check,
                session,
                settings=settings,
                tolerances=tolerances,
                weight_kg=args.weight_kg,
                force=args.force,
                report=files.get("report"),
            ),
        )
        for session, files in zip(named_sessions(args), output_files(args, "report"), strict=True)
    ]
    return over_sessions(args, jobs, console, SESSIONS)


def _check(
    folder: Path,
    console: Console,
    *,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    weight_kg: float | None,
    force: bool,
    report: Path | None,
) -> Figures:
    """List what is in every run, then calibrate: what `calibrate` refuses, this never passes."""
    session = Session.open(folder, force=force)
    checked = check_session(session, settings, tolerances, weight_kg=weight_kg)
    data, screening, outcome = checked.data, checked.data.screening, checked.outcome
    entries = [entry for entry in session.runs if entry.run in data.runs]
    if entries:
        print_table(console, _table(session, entries, data.runs))
    say(console, weight_line(data.weighed, data.robot))
    if checked.zeros:
        print_table(console, of_page(zeros_table(checked.zeros)))
    if outcome is not None:
        print_table(console, of_page(expected_table(outcome.assessment)))
    if (lost := left_out_table(screening)) is not None:
        print_table(console, of_page(lost))
    for verdict, lines in (("FAIL", checked.problems), ("WARN", checked.warnings)):
        for line in lines:
            say(console, verdict_line(verdict, line))
    if report is not None:
        # Matplotlib takes a second to load, which most calls need not wait for.
        from shoecal_core.report.check_report import CheckReport, check_report  # noqa: PLC0415

        assessed = None if outcome is None else outcome.assessment
        content = CheckReport(session, data.robot, tuple(entries), data.runs, data.aligned,
                              screening, checked.problems, checked.warnings, checked.zeros,
                              data.weighed, assessed)  # fmt: skip
        check_report(report, content)
    figures = {
        "robot": session.robot,
        "shoe": session.shoe_name,
        "runs": [_figures(entry, data.runs[entry.run]) for entry in entries],
        "problems": list(checked.problems),
        "warnings": list(checked.warnings),
        "weight": weight_json(data.weighed, data.robot),
        "zeros": list(checked.zeros),
        "screening": screening.to_json(),
        "assessment": None if outcome is None else outcome.assessment.to_json(outcome.data.shoe),
    }
    if checked.problems:
        # Of many sessions nothing is shown where one is checked.
        listed = f": {list_reasons(checked.problems)}" if console.quiet else ", listed above"
        raise UnfitSessionError(
            f"{len(checked.problems)} problem(s) in {session.folder}{listed}", figures
        )
    summary = "fit for use, with the warnings above" if checked.warnings else "fit for use"
    verdict = "WARN" if checked.warnings else "PASS"
    say(console, verdict_line(verdict, summary))
    say(console, after_check(verdict, str(session.folder)))
    return Figures(figures)


def _verdict(one: Ended[Figures]) -> str:
    return "FAIL" if one.figures["problems"] else "WARN" if one.figures["warnings"] else "PASS"


def _findings(one: Ended[Figures]) -> str:
    """The first of what is the worst, and how many more there are."""
    figures: Mapping[str, Any] = one.figures
    return list_reasons([*figures["problems"], *figures["warnings"]], 1) or "-"


SESSIONS: Mapping[str, Callable[[Ended[Figures]], str]] = {
    "verdict": _verdict,
    **EXPECTED,
    "findings": _findings,
}
"""Columns of a table with a line a session."""


def _table(session: Session, entries: Sequence[RunEntry], runs: Mapping[int, Run]) -> Table:
    table = new_table(f"{session.robot} on {session.shoe_name}")
    for name in ("run", "set", "motion", "dx dy dtheta", "s", "joints Hz", "readings Hz", "notes"):
        table.add_column(name, overflow=TEXT if name == "notes" else "ellipsis")
    for entry in entries:
        table.add_row(*_cells(entry, runs[entry.run]))
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
