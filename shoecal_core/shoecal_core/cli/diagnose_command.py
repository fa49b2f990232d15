"""`shoecal diagnose SESSION …`: where model and reality differ, and why."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import (
    add_force,
    add_rezero,
    add_sets,
    add_settings,
    add_weight,
    settings_of,
)
from shoecal_core.cli.diagnosis_table import SESSIONS, print_diagnosis
from shoecal_core.cli.many_sessions import (
    EACH,
    SessionJob,
    add_sessions,
    add_spread,
    for_workers,
    named_sessions,
    output_files,
    over_sessions,
    several,
)
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.tables import of_page, print_table
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.report.recorded_tables import zeros_table
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.diagnose import Diagnosed, DiagnosisRequest, do

SIGNALS = ("closure", "parity", "tilt", "air")
"""Signals that can be left out, to see what they are worth."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    add_sessions(parser)
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar="FILE",
        help="of these shoes: its residual gap is reported as well",
    )
    add_settings(parser, "settings of a diagnosis and tolerances")
    add_weight(parser)
    add_rezero(parser)
    add_sets(parser)
    add_force(parser)
    parser.add_argument(
        "--report",
        type=Path,
        metavar="FILE",
        help=f"also write an HTML report; {EACH}",
    )
    parser.add_argument(
        "--without",
        nargs="+",
        choices=SIGNALS,
        default=[],
        metavar="SIGNAL",
        help=f"leave signals out: {', '.join(SIGNALS)}",
    )
    parser.add_argument(
        "--only",
        nargs="+",
        type=effect_at,
        default=[],
        metavar="EFFECT[:PLACE,…]",
        help="look for nothing else, for example latency:left crosstalk",
    )
    parser.add_argument(
        "--effects-from", type=Path, metavar="FILE.py", help="look for effects of your own, too"
    )
    parser.add_argument(
        "--no-simulation", action="store_true", help="do not replay the motions in the simulator"
    )
    add_spread(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Diagnose one session, or many at once."""
    asked = requests(args)
    if several(args):
        jobs = [SessionJob(one.session, partial(_diagnose, one)) for one in asked]
        return over_sessions(args, jobs, console, SESSIONS)
    with shown_progress() as progress:
        found = do(asked[0], progress)
    print_diagnosis(found.diagnosis, found.calibrated, console)
    if found.zeros:
        print_table(console, of_page(zeros_table(found.zeros)))
    return found.to_json()


def _diagnose(request: DiagnosisRequest, _: Console) -> Diagnosed:
    """In another process, which shows no steps."""
    return do(request)


def effect_at(text: str) -> tuple[str, tuple[str, ...]]:
    """An effect, and where it is looked for: `crosstalk:left/front_left,left/rear_left`."""
    effect, _, places = text.partition(":")
    location = tuple(filter(None, places.split(",")))
    if not effect or (":" in text and not location):
        raise argparse.ArgumentTypeError(
            f"'{text}': expected an effect and, after a colon, its place: latency:left"
        )
    return effect, location


def requests(args: argparse.Namespace) -> list[DiagnosisRequest]:
    """A request a session; for workers elsewhere with whole paths."""
    settings = settings_of(DiagnosisSettings, args.settings, "diagnosis")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    screening = settings_of(CalibrationSettings, args.settings, "calibration")
    calibration, effects_from = (
        None if path is None else for_workers(args, path)
        for path in (args.calibration, args.effects_from)
    )
    return [
        DiagnosisRequest(
            session=session,
            settings=settings,
            tolerances=tolerances,
            screening=screening,
            calibration=calibration,
            weight_kg=args.weight_kg,
            rezero=args.rezero,
            train=args.train,
            test=args.test,
            without=frozenset(args.without),
            only=tuple(args.only),
            effects_from=effects_from,
            simulate=not args.no_simulation,
            force=args.force,
            report=files.get("report"),
        )
        for session, files in zip(named_sessions(args), output_files(args, "report"), strict=True)
    ]
