"""`shoecal evaluate SESSION … --calibration FILE`: how far a calibration is off.

Against the model always; against the simulator's truth where the session has one; against
another calibration, for example a manual one, where one is given. Several sessions are judged one
by one and together. The verdict is on errors against the model, in per cent of the weight and of
half the width of a foot.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import add_force, add_rezero, add_sets, add_weight, require_folder
from shoecal_core.cli.many_sessions import (
    Ended,
    SessionJob,
    add_sessions,
    add_spread,
    each_session,
    figures_of,
    named_sessions,
    one_a_session,
    print_sessions,
    raise_failed,
    several,
)
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
from shoecal_core.errors import PartialError
from shoecal_core.estimation.run_errors import ComparedRun, errors_by_set, errors_of
from shoecal_core.estimation.series import Errors
from shoecal_core.recording.session import Session
from shoecal_core.report.recorded_tables import zeros_table
from shoecal_core.screening.verdict import VERDICTS, Verdict, list_reasons, split_reason
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
    add_sessions(parser, "; several are judged one by one and together")
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
    add_spread(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Compare on every run, and by set."""
    if args.json is not None:
        require_folder(args.json)
    jobs = [
        SessionJob(
            session,
            partial(
                _evaluate,
                session,
                calibration=calibration,
                reference=reference,
                train=args.train,
                test=args.test,
                rezero=args.rezero,
                weight_kg=args.weight_kg,
                force=args.force,
            ),
        )
        for session, calibration, reference in zip(
            named_sessions(args),
            one_a_session(args, "--calibration", args.calibration),
            one_a_session(args, "--reference", args.reference),
            strict=True,
        )
    ]
    if not several(args):
        return _judge([jobs[0].work(console)], {}, console)
    ended = each_session(args, jobs)
    print_sessions(ended, console, SESSIONS)
    figures = figures_of(ended)
    found = [one.found for one in ended if one.found is not None]
    if not all(one.sources == found[0].sources for one in found):
        raise PartialError(
            "some sessions have a simulated truth and some have none; evaluate them apart", figures
        )
    for note in dict.fromkeys(note for one in found for note in one.notes):
        say(console, note)
    if len(found) < len(ended):
        if found:
            figures |= _figures(found)
            _print(found, console)
        raise_failed(ended, figures)
    return _judge(found, figures, console)


@dataclass(frozen=True)
class _One:
    """A calibration on one session.

    Attributes:
        session: its folder.
        calibrations, references: their names; no reference, or one.
        notes: on their versions, a line each.
        evaluated: on all runs.
        rezeroed: each with its own zeros.
    """

    session: str
    calibrations: tuple[str, ...]
    references: tuple[str, ...]
    notes: tuple[str, ...]
    evaluated: Evaluated
    rezeroed: bool

    @property
    def sources(self) -> set[str]:
        """Whatever its runs have series of."""
        return {name for run in self.evaluated.runs for name in run.sources}

    def to_json(self) -> dict[str, object]:
        """Figures of this session alone."""
        return _figures([self])


def _evaluate(
    folder: Path,
    console: Console,
    *,
    calibration: Path | None,
    reference: Path | None,
    train: Sequence[int],
    test: Sequence[int],
    rezero: bool,
    weight_kg: float | None,
    force: bool,
) -> _One:
    """Compare on every run of a session."""
    session = Session.open(folder, force=force)
    assert calibration is not None
    judged = load_calibration_of(calibration, session)
    better = None if reference is None else load_calibration_of(reference, session)
    named = [one for one in (judged, better) if one is not None]
    notes = [f"Note: {note}." for one in named if (note := version_note(one, session))]
    for note in notes:
        say(console, note)
    evaluated = evaluate_session(
        session, judged, better, train, test, rezero=rezero, weight_kg=weight_kg
    )
    references = () if better is None else (better.id,)
    return _One(str(session.folder), (judged.id,), references, tuple(notes), evaluated, rezero)


def _runs(found: Sequence[_One]) -> list[ComparedRun]:
    return [run for one in found for run in one.evaluated.runs]


def _worst(found: Sequence[_One]) -> Verdict:
    return max(
        (one.evaluated.verdict for one in found), key=lambda one: VERDICTS.index(one.verdict)
    )


def _judge(
    found: Sequence[_One], figures: Mapping[str, object], console: Console
) -> Mapping[str, object]:
    """Show and return the figures of all sessions together, next to those that there are.

    Raises:
        PoorCalibrationError: one of them has the verdict FAIL.
    """
    _print(found, console)
    figures, worst = {**figures, **_figures(found)}, _worst(found)
    if worst.verdict == "FAIL":
        raise PoorCalibrationError(list_reasons(worst.reasons, 1), figures)
    return figures


def _figures(found: Sequence[_One]) -> dict[str, object]:
    """Of all runs together, for machines."""
    runs, evaluated = _runs(found), [one.evaluated for one in found]
    return {
        "format": 1,
        "verdict": _worst(found).verdict,
        "reasons": [reason for one in evaluated for reason in one.verdict.reasons],
        "weight": [weight_json(one.weighed, one.robot) for one in evaluated],
        "zeros": [
            {"session": one.session, **zero} for one in found for zero in one.evaluated.zeros
        ],
        "rezeroed": found[0].rezeroed,
        "model_limit": [
            {name: limit.to_json() for name, limit in one.limits.items()} for one in evaluated
        ],
        "calibrations": [name for one in found for name in one.calibrations],
        "references": [name for one in found for name in one.references],
        **_errors_to_json(runs, MEASURED),
        "model": _errors_to_json(runs, MODELLED),
        "reference": _errors_to_json(runs, REFERENCE),
        "runs": [_run_to_json(one) for one in runs],
    }


def _print_verdicts(evaluated: Sequence[Evaluated], console: Console) -> None:
    """Weight, zeros and verdict of each session."""
    for one in evaluated:
        say(console, weight_line(one.weighed, one.robot))
        if one.zeros:
            print_table(console, of_page(zeros_table(one.zeros)))
        for reason in one.verdict.reasons:
            level, text = split_reason(reason, one.verdict.verdict)
            say(console, verdict_line(level, text))


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


def _shown(one: Ended[_One], text: Callable[[Errors], str]) -> str:
    """Of the test runs, where there are any, against the best that is known."""
    assert one.found is not None
    runs = one.found.evaluated.runs
    sets = errors_by_set(runs, MEASURED, _best(runs))
    return text(sets.get("test", sets[next(iter(sets))]))


def _against(one: Ended[_One]) -> str:
    assert one.found is not None
    runs = one.found.evaluated.runs
    name = "test" if any(run.set == "test" for run in runs) else "train"
    return f"{name}, {NAMES[_best(runs)]}"


def _reasons(one: Ended[_One]) -> str:
    """The first, and how many more there are."""
    return "" if one.found is None else list_reasons(one.found.evaluated.verdict.reasons, 1)


SESSIONS: Mapping[str, Callable[[Ended[_One]], str]] = {
    "verdict": lambda one: str(one.figures["verdict"]),
    "GRF (N)": lambda one: _shown(one, lambda errors: f"{errors.grf.mean:.2f}"),
    "CoP (mm)": lambda one: _shown(one, lambda errors: f"{1e3 * errors.cop.mean:.2f}"),
    "runs, against": _against,
    "reasons": _reasons,
}
"""Columns of a table with a line a session."""


def _print(found: Sequence[_One], console: Console) -> None:
    """Errors of all runs together and run by run, then what is known of each session."""
    runs = _runs(found)
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
    _print_verdicts([one.evaluated for one in found], console)
