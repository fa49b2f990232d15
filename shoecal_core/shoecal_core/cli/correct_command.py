"""`shoecal correct SESSION --out DIR`: what was found of a robot, in copies of its files."""

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
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import new_table, print_table
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FileTakenError, ShoecalError
from shoecal_core.files import atomic_write, make_folder
from shoecal_core.recording.session import Session
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.diagnosed_correction import correct_by_diagnosis
from shoecal_core.workflows.model_correction import MJCF, Corrected, Found, correct_robot

SIGNIFICANT = 2.0
"""Standard deviations from zero; what is less is written too, and not shown."""
FIGURES = {
    "joint_offset": ("zero", 1e3, "mrad"),
    "link_mass": ("mass", 1e2, "%"),
    "link_com": ("CoM", 1e3, "mm"),
    "payload": ("mass", 1.0, "kg"),
    "total_mass": ("mass", 1.0, "kg"),
    "joint_compliance": ("compliance", 1e3, "mrad/(N m)"),
    "backlash": ("play", 1e3, "mrad"),
    "latency": ("latency", 1e3, "ms"),
}
"""What is shown of each effect, its scale and unit."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("session", type=Path, help="folder of a recorded or imported session")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR",
        help="folder for the corrected robot.yaml and robot.urdf, and randomisation.yaml",
    )  # fmt: skip
    parser.add_argument(
        "--diagnosis", type=Path, metavar="FILE.json",
        help="correct by the causes of this diagnosis of the session (diagnose --json) instead of "
        "a fit",
    )  # fmt: skip
    parser.add_argument(
        "--mjcf", type=Path, metavar="MODEL.xml",
        help="MJCF of the robot, of which a corrected copy is made, too: robot.xml",
    )  # fmt: skip
    add_sets(parser)
    add_settings(parser, "weights and tolerances")
    add_force(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Correct, and write what brings the model nearer to the measured CoP."""
    session = Session.open(args.session, force=args.force)
    if args.mjcf and args.mjcf.resolve() == (args.out / MJCF).resolve():
        raise FileTakenError(args.mjcf, "would be overwritten; name another folder with --out")
    if args.diagnosis:
        if args.train or args.test or args.settings:
            raise ShoecalError(
                "--train, --test and --settings are of a fit; leave them out with --diagnosis"
            )
        corrected, found = correct_by_diagnosis(session, args.diagnosis, args.mjcf)
        print_table(console, _table("By the diagnosis", corrected.found))
        before, after = found.cop_mae_mm
        compared = f"{before:.2f} mm before, {after:.2f} mm after, on test runs of the diagnosis"
        say(console, f"CoP against the model: {compared}")
        written = _write(args.out, corrected, found.left, console)
        return written | {"before": {"cop_mae_mm": before}, "after": {"cop_mae_mm": after}}
    settings = settings_of(CalibrationSettings, args.settings, "calibration")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    with shown_progress() as progress:
        robot = correct_robot(
            session, args.train, args.test, settings, tolerances, args.mjcf, progress
        )
    certain = [one for one in robot.corrected.found if abs(one.value) > SIGNIFICANT * one.std]
    if not certain:
        raise ShoecalError(
            "nothing written: no joint zero and no mass is more than "
            f"{SIGNIFICANT:g} standard deviations from the robot's files"
        )
    print_table(
        console, _table(f"More than {SIGNIFICANT:g} standard deviations from the files", certain)
    )
    before, after = (1e3 * errors.cop.mean for errors in (robot.before, robot.after))
    compared = f"{before:.2f} mm before, {after:.2f} mm after, on runs that were not fitted"
    say(console, f"CoP against the model: {compared}")
    if not robot.better:
        raise ShoecalError(f"nothing written, the robot's files are better as they are: {compared}")
    return _write(args.out, robot.corrected, (), console) | {
        "runs": list(robot.runs),
        "before": robot.before.to_json(),
        "after": robot.after.to_json(),
    }


def _write(
    out: Path, corrected: Corrected, left: Sequence[str], console: Console
) -> dict[str, object]:
    """Write the files; figures of them."""
    make_folder(out)
    for name, text in corrected.files.items():
        atomic_write(out / name, text)
        say(console, f"wrote {out / name}")
    for line in (*left, *corrected.left):
        say(console, f"left out: {line}")
    return {
        "files": [str(out / name) for name in corrected.files],
        "left_out": [*left, *corrected.left],
        "changes": [
            {
                "effect": one.effect,
                "location": list(one.location),
                "component": one.component,
                "unit": one.unit,
                "value": one.value,
                "std": one.std,
            }
            for one in corrected.found
        ],
    }


def _table(title: str, found: Sequence[Found]) -> Table:
    table = new_table(title)
    for heading in ("Joint or link", "What", "Off by"):
        table.add_column(heading)
    for one in found:
        what, scale, unit = FIGURES[one.effect]
        axis = f" {one.component}" if one.effect == "link_com" else ""
        off = f"{scale * one.value:+.1f} ± {scale * one.std:.1f} {unit}"
        if unit == "kg":
            off = f"{one.value:+.3f} ± {one.std:.3f} kg"
        table.add_row(", ".join(one.location), f"{what}{axis}", off)
    return table
