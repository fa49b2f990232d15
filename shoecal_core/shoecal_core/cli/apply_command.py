"""`shoecal apply SESSION --calibration FILE`: recorded readings as GRF and CoP, in tables."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rich.console import Console

from shoecal_core.arrays import FloatArray
from shoecal_core.cli.arguments import add_force, add_rezero
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import verdict_line
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.checks.accuracy import GRF_FAIL
from shoecal_core.files import atomic_write, make_folder
from shoecal_core.recording.session import Session
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.verdict import name_runs
from shoecal_core.workflows.apply import apply, at_own_zeros
from shoecal_core.workflows.evaluation import load_calibration_of

DIGITS = 7
"""Significant ones of each number."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of a recorded or imported session")
    parser.add_argument(
        "--calibration", type=Path, required=True, metavar="FILE", help="calibration to apply"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR",
        help="folder for the tables, one a run: run_NNN.csv",
    )  # fmt: skip
    add_rezero(parser)
    add_force(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Write a table a run."""
    session = Session.open(args.session, force=args.force)
    calibration = load_calibration_of(args.calibration, session)
    if calibration.verdict == "FAIL":
        raise ShoecalError(f"{args.calibration}: failed its checks, so it is not applied")
    robot = load_robot(session.robot_yaml, session.shoe)
    sensing, kinematics = calibration.sensing(session.shoe), Kinematics(robot)
    make_folder(args.out)
    rows: list[dict[str, object]] = []
    entries, shares = session.runs, dict[int, float]()
    with shown_progress() as progress:
        for index, entry in enumerate(entries):
            progress(f"run {entry.run}", index / len(entries))
            recorded = session.read(entry.run)
            own = at_own_zeros(recorded, sensing, kinematics) if args.rezero else sensing
            found = apply(recorded, own, kinematics)
            file = args.out / f"run_{entry.run:03d}.csv"
            atomic_write(file, _table(found.columns()))
            grf = found.measured.total_grf
            if not entry.info.hanging and np.isfinite(grf).any():
                shares[entry.run] = float(np.nanmedian(grf)) / robot.weight
            known = int(np.isfinite(found.cop).all(axis=1).sum())
            rows.append({"run": entry.run, "file": str(file), "samples": len(found.time),
                         "with_cop": known})  # fmt: skip
            say(
                console,
                f"{file}: {len(found.time)} samples, {known} of them with a CoP of both feet",
            )
    far = [run for run, share in shares.items() if abs(share - 1.0) > GRF_FAIL]
    warnings = []
    if far:
        usual = float(np.median([shares[run] for run in far]))
        warnings.append(
            f"{name_runs(far)}: GRF is {usual:.0%} of the weight in the median: see that "
            f"{args.calibration} is of these shoes, unedited, and that their zeros have not "
            "changed since (--rezero)"
        )
        say(console, verdict_line("WARN", warnings[0]))
    return {"calibration": calibration.id, "runs": rows, "warnings": warnings}


def _table(columns: Mapping[str, FloatArray]) -> str:
    """A CSV table; nothing stands where a value is not known."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*(values.tolist() for values in columns.values()), strict=True):
        writer.writerow("" if value != value else f"{value:.{DIGITS}g}" for value in row)  # noqa: PLR0124 - not a number
    return buffer.getvalue()
