"""`shoecal diagnose SESSION …`: where model and reality differ, and why."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import (
    add_force,
    add_rezero,
    add_sets,
    add_settings,
    add_weight,
    require_folder,
    settings_of,
)
from shoecal_core.cli.diagnosis_table import print_diagnosis, sessions_table
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.tables import of_page, print_table
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import PartialError, ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.recording.errors import SessionError
from shoecal_core.report.recorded_tables import zeros_table
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.diagnose import Diagnosed, DiagnosisRequest, attempt, do, lost
from shoecal_core.workflows.many_jobs import over_cluster, over_cores

SIGNALS = ("closure", "parity", "tilt", "air")
"""Signals that can be left out, to see what they are worth."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument(
        "sessions", type=Path, nargs="+", metavar="SESSION", help="folder of a recorded session"
    )
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
        help="also write an HTML report; for several sessions one each, FILE_SESSION",
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
    parser.add_argument(
        "--jobs", type=_jobs, metavar="N", help="sessions at a time (default: one a core)"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="spread sessions over this Dask scheduler's workers"
    )


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Diagnose one session, or many at once."""
    for path in filter(None, (args.report, args.json)):
        require_folder(path)
    jobs = requests(args)
    if len(jobs) == 1 and args.scheduler is None:
        with shown_progress() as progress:
            found = do(jobs[0], progress)
        assert found.diagnosis is not None
        print_diagnosis(found.diagnosis, found.calibrated, console)
        if found.zeros:
            print_table(console, of_page(zeros_table(found.zeros)))
        return found.to_json()
    return _many(jobs, args, console)


def effect_at(text: str) -> tuple[str, tuple[str, ...]]:
    """An effect, and where it is looked for: `crosstalk:left/front_left,left/rear_left`."""
    effect, _, places = text.partition(":")
    location = tuple(filter(None, places.split(",")))
    if not effect or (":" in text and not location):
        raise argparse.ArgumentTypeError(
            f"'{text}': expected an effect and, after a colon, its place: latency:left"
        )
    return effect, location


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number, 1 or more")
    return int(text)


def requests(args: argparse.Namespace) -> list[DiagnosisRequest]:
    """A request a session; for workers elsewhere with whole paths."""
    several = len(args.sessions) > 1
    if args.scheduler:
        for name in ("calibration", "effects_from", "report"):
            if (path := getattr(args, name)) is not None:
                setattr(args, name, path.absolute())
    settings = settings_of(DiagnosisSettings, args.settings, "diagnosis")
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    screening = settings_of(CalibrationSettings, args.settings, "calibration")
    jobs, seen = [], set()
    for session in args.sessions:
        if session.resolve() in seen:
            raise SessionError(session, "is named twice; name each session once")
        seen.add(session.resolve())
        jobs.append(
            DiagnosisRequest(
                session=session.absolute() if args.scheduler else session,
                settings=settings,
                tolerances=tolerances,
                screening=screening,
                calibration=args.calibration,
                weight_kg=args.weight_kg,
                rezero=args.rezero,
                train=args.train,
                test=args.test,
                without=frozenset(args.without),
                only=tuple(args.only),
                effects_from=args.effects_from,
                simulate=not args.no_simulation,
                force=args.force,
                report=_report(args.report, session) if several else args.report,
            )
        )
    reports = [job.report for job in jobs if job.report is not None]
    if len(set(reports)) < len(reports):
        raise ShoecalError("--report: two sessions have folders of one name; diagnose them apart")
    return jobs


def _report(path: Path | None, session: Path) -> Path | None:
    if path is None:
        return None
    return path.with_name(f"{path.stem}_{session.resolve().name}{path.suffix}")


def _many(
    jobs: Sequence[DiagnosisRequest], args: argparse.Namespace, console: Console
) -> Mapping[str, object]:
    """All of them; those that cannot be diagnosed are listed at the end."""
    results: dict[int, Diagnosed] = {}
    with shown_progress() as progress:
        progress(f"diagnosing {len(jobs)} sessions", 0.0)
        coming = (
            over_cores(attempt, jobs, args.jobs, lost=lost)
            if args.scheduler is None
            else over_cluster(attempt, jobs, args.scheduler, lost=lost)
        )
        for number, found in coming:
            results[number] = found
            progress(f"{found.session}", len(results) / len(jobs))
            if args.json is not None:  # what is done stays, whatever becomes of the others
                figures = _figures(results, jobs)
                atomic_write(args.json, json.dumps(figures, indent=1, allow_nan=False) + "\n")
    ordered = [results[number] for number in range(len(jobs))]
    print_table(console, sessions_table(ordered))
    figures = _figures(results, jobs)
    failed = [one for one in ordered if one.diagnosis is None]
    if failed:
        errors = "; ".join(one.error for one in failed)
        raise PartialError(f"{len(failed)} of {len(jobs)} sessions failed: {errors}", figures)
    return figures


def _figures(
    results: Mapping[int, Diagnosed], jobs: Sequence[DiagnosisRequest]
) -> dict[str, object]:
    """Sessions that are done, in the order in which they were named, and those that are not yet."""
    done = [results[number].to_json() for number in sorted(results)]
    waiting = [str(job.session) for number, job in enumerate(jobs) if number not in results]
    return {"format": 1, "sessions": done, **({"waiting": waiting} if waiting else {})}
