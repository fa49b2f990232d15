"""`shoecal correct SESSION --out DIR`: found joint zeros and masses in a robot's files."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from shoecal_core.cli.arguments import (
    add_force,
    add_sets,
    add_settings,
    settings_of,
)
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.tables import new_table
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.joint_fit import FittedDeviation
from shoecal_core.files import atomic_write, make_folder
from shoecal_core.recording.session import Session
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.model_correction import COM, JOINT_ZERO, MASS, correct_robot

SIGNIFICANT = 2.0
"""Standard deviations from zero; what is less is written too, and not shown."""
FIGURES = {JOINT_ZERO: ("zero", 1e3, "mrad"), MASS: ("mass", 1e2, "%"), COM: ("CoM", 1e3, "mm")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of a recorded or imported session")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR",
        help="folder for the corrected robot.yaml and robot.urdf",
    )  # fmt: skip
    add_sets(parser)
    add_settings(parser, "weights and tolerances")
    add_force(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Fit, compare, and write what brings the model nearer to the measured CoP."""
    settings = settings_of(CalibrationSettings, args.settings, "calibration")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    session = Session.open(args.session, force=args.force)
    with shown_progress() as progress:
        robot = correct_robot(session, args.train, args.test, settings, tolerances, progress)
    certain = [one for one in robot.found if abs(one.value) > SIGNIFICANT * one.std]
    if not certain:
        raise ShoecalError(
            "nothing written: no joint zero and no mass is more than "
            f"{SIGNIFICANT:g} standard deviations from the robot's files"
        )
    console.print(_table(certain))
    before, after = (1e3 * errors.cop.mean for errors in (robot.before, robot.after))
    compared = f"{before:.2f} mm before, {after:.2f} mm after, on runs that were not fitted"
    console.print(f"CoP against the model: {compared}", markup=False, soft_wrap=True)
    if not robot.better:
        raise ShoecalError(f"nothing written, the robot's files are better as they are: {compared}")
    make_folder(args.out)
    for name, text in robot.files.items():
        atomic_write(args.out / name, text)
        console.print(f"wrote {args.out / name}", markup=False, soft_wrap=True)
    return {
        "files": [str(args.out / name) for name in robot.files],
        "runs": list(robot.runs),
        "before": robot.before.to_json(),
        "after": robot.after.to_json(),
        "changes": [
            {
                "effect": one.deviation.effect,
                "location": list(one.deviation.location),
                "component": one.deviation.component,
                "unit": one.deviation.unit,
                "value": one.value,
                "std": one.std,
            }
            for one in robot.found
        ],
    }


def _table(certain: Sequence[FittedDeviation]) -> Table:
    table = new_table(f"More than {SIGNIFICANT:g} standard deviations from the files")
    for heading in ("Joint or link", "What", "Off by"):
        table.add_column(heading)
    for one in certain:
        what, scale, unit = FIGURES[one.deviation.effect]
        axis = f" {one.deviation.component}" if one.deviation.effect == COM else ""
        off = f"{scale * one.value:+.1f} ± {scale * one.std:.1f} {unit}"
        table.add_row(one.deviation.location[0], f"{what}{axis}", off)
    return table
