"""`shoecal check SESSION`: what is in it, and is it fit for use."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rich.console import Console

from shoecal_core.calibration.checks import check_readings
from shoecal_core.calibration.pipeline import load_data
from shoecal_core.commands.tables import new_table
from shoecal_core.errors import ShoecalError
from shoecal_core.model.robot_file import load_robot
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import RunEntry, Session


class UnfitSessionError(ShoecalError):
    """A session that cannot be calibrated from as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of the recorded session")


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Read every run, say what is in it, and name whatever is in the way of a calibration."""
    session = Session.open(args.session)
    problems = [
        f"{path.name} was not finished: rescue it with `shoecal recover {path}`"
        for path in session.unfinished
    ] + [f"run {run} was begun but its file is gone: put it back" for run in session.missing]
    # A robot or shoe file that cannot be used is told as itself, not as another file's hash.
    load_robot(session.robot_yaml, session.shoe, urdf=session.robot_urdf)
    table = new_table(f"{session.robot} on {session.shoe_name}")
    for name in ("run", "set", "motion", "dx dy dtheta", "s", "joints Hz", "readings Hz", "notes"):
        table.add_column(name)
    rows = []
    for entry in session.runs:
        try:
            recorded = session.read(entry.run)
            findings = check_readings(session.shoe, load_data(session, [entry.run]).of([entry.run]))
            problems += [f"run {entry.run}: {finding.reason}" for finding in findings]
        except ShoecalError as error:
            problems.append(str(error))
            continue
        rows.append(_figures(entry, recorded))
        table.add_row(*_cells(entry, recorded))
    console.print(table)
    if not rows:
        problems.append(f"{session.folder}: no run can be read; record some")
    for problem in problems:
        console.print(f"- {problem}", markup=False, soft_wrap=True)
    if problems:
        raise UnfitSessionError(f"{len(problems)} problem(s) in {session.folder}, listed above")
    console.print("fit for use")
    return {"robot": session.robot, "shoe": session.shoe_name, "runs": rows, "problems": problems}


def _figures(entry: RunEntry, run: Run) -> dict[str, object]:
    support = entry.info.support
    return {
        "run": entry.run,
        "set": entry.hint,
        "motion": entry.info.motion,
        "support": None if support is None else [support.dx, support.dy, support.dtheta],
        "duration_s": float(run.readings.time[-1] - run.readings.time[0]),
        "joints_hz": _rate(run.joints.time),
        "readings_hz": _rate(run.readings.time),
        "notes": list(run.notes),
    }


def _cells(entry: RunEntry, run: Run) -> list[str]:
    support = entry.info.support
    return [
        str(entry.run),
        entry.hint or "-",
        entry.info.motion,
        "-"
        if support is None
        else f"{1e3 * support.dx:.0f} {1e3 * support.dy:.0f} mm {np.degrees(support.dtheta):.0f}°",
        f"{run.readings.time[-1] - run.readings.time[0]:.1f}",
        f"{_rate(run.joints.time):.0f}",
        f"{_rate(run.readings.time):.0f}",
        "; ".join(run.notes) or "-",
    ]


def _rate(time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    return float(1.0 / np.median(np.diff(time))) if len(time) > 1 else 0.0
