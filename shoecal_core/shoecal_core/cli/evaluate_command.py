"""`shoecal evaluate SESSION --calibration FILE`: how far a calibration is off.

Against the model always; against the simulator's truth where the session has one; against
another calibration, for example a manual one, where one is given. Several sessions are judged
together. The verdict is on errors against the model, in per cent of the weight and of half the
width of a foot.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import add_force, add_rezero, add_sets, add_weight
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import (
    errors_table,
    left_out_lines,
    of_page,
    print_table,
    stages_rows,
    verdict_line,
)
from shoecal_core.cli.weight import weight_json, weight_line
from shoecal_core.errors import PartialError, ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set, errors_of
from shoecal_core.estimation.series import Errors
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_core.report.recorded_tables import zeros_table
from shoecal_core.screening.verdict import VERDICTS, list_reasons, split_reason
from shoecal_core.workflows.evaluation import (
    MEASURED,
    MODELLED,
    REFERENCE,
    TRUTH,
    Evaluated,
    evaluate_session,
    load_calibration_of,
    version_note,
)

NAMES = {MODELLED: "the files' model", REFERENCE: "reference", TRUTH: "truth"}


class PoorCalibrationError(PartialError):
    """A calibration that is too far off on these runs."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument(
        "sessions",
        type=Path,
        nargs="+",
        metavar="SESSION",
        help="folder of a recorded session; several are judged together",
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        required=True,
        action="append",
        metavar="FILE",
        help="the one to judge; for several sessions one for all, or the option once a session",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="a calibration taken as right, for example a manual one; likewise",
    )
    add_rezero(parser)
    add_weight(parser)
    add_sets(parser)
    add_force(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Compare on every run, and by set."""
    sessions = _open(args.sessions, force=args.force)
    calibrations = _one_a_session("--calibration", args.calibration, sessions)
    references = _one_a_session("--reference", args.reference, sessions)
    runs: list[ComparedRun] = []
    evaluated: list[Evaluated] = []
    for session, calibration, reference in zip(sessions, calibrations, references, strict=True):
        assert calibration is not None
        for named in filter(None, (calibration, reference)):
            if note := version_note(named, session):
                say(console, f"Note: {note}.")
        one = evaluate_session(
            session, calibration, reference, args.train, args.test,
            rezero=args.rezero, weight_kg=args.weight_kg,
        )  # fmt: skip
        evaluated.append(one)
        runs += one.runs
    if not all(run.sources.keys() == runs[0].sources.keys() for run in runs):
        raise ShoecalError(
            "some sessions have a simulated truth and some have none; evaluate them apart"
        )
    _print(runs, console)
    worst = max((one.verdict for one in evaluated), key=lambda one: VERDICTS.index(one.verdict))
    _print_verdicts(evaluated, console)
    figures: dict[str, object] = {
        "format": 1,
        "verdict": worst.verdict,
        "reasons": [reason for one in evaluated for reason in one.verdict.reasons],
        "weight": [weight_json(one.weighed, one.robot) for one in evaluated],
        "zeros": [
            {"session": str(session.folder), **zero}
            for session, one in zip(sessions, evaluated, strict=True)
            for zero in one.zeros
        ],
        "rezeroed": args.rezero,
        "model_limit": [
            {name: limit.to_json() for name, limit in one.limits.items()} for one in evaluated
        ],
        "calibrations": [one.id for one in calibrations if one is not None],
        "references": [one.id for one in references if one is not None],
        **_errors_to_json(runs, MEASURED),
        "model": _errors_to_json(runs, MODELLED),
        "reference": _errors_to_json(runs, REFERENCE),
        "runs": [_run_to_json(one) for one in runs],
    }
    if worst.verdict == "FAIL":
        raise PoorCalibrationError(list_reasons(worst.reasons, 1), figures)
    return figures


def _print_verdicts(evaluated: Sequence[Evaluated], console: Console) -> None:
    """Weight, zeros and verdict of each session."""
    for one in evaluated:
        say(console, weight_line(one.weighed, one.robot))
        if one.zeros:
            print_table(console, of_page(zeros_table(one.zeros)))
        for reason in one.verdict.reasons:
            level, text = split_reason(reason, one.verdict.verdict)
            say(console, verdict_line(level, text))


def _open(folders: Sequence[Path], *, force: bool) -> list[Session]:
    """Open each session; one named twice would count its runs twice."""
    seen = set()
    for folder in folders:
        if folder.resolve() in seen:
            raise SessionError(folder, "is named twice; name each session once")
        seen.add(folder.resolve())
    return [Session.open(folder, force=force) for folder in folders]


def _one_a_session(
    option: str, paths: Sequence[Path], sessions: Sequence[Session]
) -> list[Calibration | None]:
    if not paths:
        return [None] * len(sessions)
    if len(paths) not in {1, len(sessions)}:
        raise ShoecalError(
            f"{option} was given {len(paths)} times for {len(sessions)} session(s); give it once "
            "for all, or once a session in their order"
        )
    each = list(paths) * len(sessions) if len(paths) == 1 else paths
    return [
        load_calibration_of(path, session) for path, session in zip(each, sessions, strict=True)
    ]


def _references(runs: Sequence[ComparedRun], source: str) -> list[str]:
    """What a source can be held against: everything known to be better."""
    order = (MEASURED, MODELLED, REFERENCE, TRUTH)
    better = order[max(order.index(source), order.index(MEASURED)) + 1 :]
    return [name for name in better if {name, source} <= runs[0].sources.keys()]


def _best(runs: Sequence[ComparedRun]) -> str:
    return _references(runs, MEASURED)[-1]


def _errors_to_json(runs: Sequence[ComparedRun], source: str) -> dict[str, object]:
    return {
        f"against_{reference}": {
            name: found.to_json() for name, found in errors_by_set(runs, source, reference).items()
        }
        for reference in _references(runs, source)
    }


def _run_to_json(run: ComparedRun) -> dict[str, object]:
    def against(source: str) -> dict[str, object]:
        return {
            f"against_{reference}": errors_of([run], source, reference).to_json()
            for reference in _references([run], source)
        }

    own = {"session": run.session, "run": run.run, "set": run.set}
    return {**own, **against(MEASURED), "model": against(MODELLED)}


def _print(runs: Sequence[ComparedRun], console: Console) -> None:
    best = _best(runs)
    sets = {
        f"against {NAMES[reference]}": errors_by_set(runs, MEASURED, reference)
        for reference in _references(runs, MEASURED)
    }
    print_table(console, errors_table("Calibration", stages_rows(sets)))
    others = {
        f"{NAMES[source]} against {NAMES[reference]}": errors_by_set(runs, source, reference)
        for source in (MODELLED, REFERENCE)
        for reference in _references(runs, source)
    }
    if others:
        print_table(console, errors_table("For comparison", stages_rows(others)))
    several = len({one.session for one in runs}) > 1
    rows: list[tuple[str, Errors]] = []
    for one in runs:
        where = f"{Path(one.session).name}, " if several else ""
        rows.append((f"{where}run {one.run}, {one.set}", errors_of([one], MEASURED, best)))
    print_table(console, errors_table(f"Calibration against {NAMES[best]}, run by run", rows))
    for line in left_out_lines(rows, feet=best != MODELLED):
        say(console, line)
