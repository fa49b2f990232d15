"""`shoecal calibrate SESSION …`: find gains and offsets from a recorded session."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from shoecal_core.cli.arguments import (
    add_force,
    add_rezero,
    add_sets,
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
    one_a_session,
    output_files,
    over_sessions,
)
from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import errors_table, new_table, of_page, print_table, stages_rows
from shoecal_core.cli.trust import trust_lines
from shoecal_core.cli.usable import require_usable
from shoecal_core.cli.weight import weight_json, weight_line
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.estimation.initial_guess import InitialGuess
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.assessment_tables import expected_table
from shoecal_core.report.next_step import after_calibration
from shoecal_core.report.quantities import channel_units, uncertain
from shoecal_core.report.recorded_tables import left_out_table, zeros_table
from shoecal_core.screening.settings import JOINT, PAPER, CalibrationSettings
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.workflows.calibrate import calibrate_session

SURE = 3.0
"""Standard deviations from which on a deviation is listed as significant."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    add_sessions(parser)
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        required=True,
        help=f"calibration file to write; {EACH}",
    )
    parser.add_argument(
        "--report", type=Path, metavar="FILE", help=f"also write an HTML report; {EACH}"
    )
    add_settings(parser, "weights and tolerances")
    parser.add_argument(
        "--manual",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="calibration of these shoes by `shoecal manual shoe`: where cells and plates carry, "
        "and the gains, are then known beforehand; for several sessions one for all, or the option "
        "once a session",
    )
    parser.add_argument(
        "--method",
        choices=(JOINT, PAPER),
        help="joint: gains and offsets together with all that robot and shoes may have wrong "
        "(the default); paper: least squares over gains and offsets alone, then a CoP correction",
    )
    add_weight(parser)
    add_rezero(parser)
    add_sets(parser)
    add_force(parser)
    add_spread(parser)


def _against(outcome: CalibrationOutcome) -> str:
    """What errors are counted against: no other command has the model as the fit corrects it."""
    fitted = " as the fit corrects it" if outcome.joint is not None else ""
    return f"Measured against the model{fitted}"


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Calibrate from one session, or from many at once, each by itself."""
    settings = settings_of(CalibrationSettings, args.settings, "calibration")
    settings = replace(settings, method=args.method or settings.method)
    tolerances = settings_of(Tolerances, args.settings, "tolerances")
    sessions, outputs = named_sessions(args), output_files(args, "out", "report")
    jobs = [
        SessionJob(
            session,
            partial(
                _calibrate,
                session,
                settings=settings,
                tolerances=tolerances,
                manual=manual,
                train=args.train,
                test=args.test,
                weight_kg=args.weight_kg,
                rezero=args.rezero,
                force=args.force,
                out=files["out"],
                report=files.get("report"),
            ),
        )
        for session, files, manual in zip(
            sessions,
            outputs,
            one_a_session(args, "--manual", args.manual),
            strict=True,
        )
    ]
    written = {job.session: files["out"] for job, files in zip(jobs, outputs, strict=True)}
    columns: dict[str, Callable[[Ended[Figures]], str]] = {
        "verdict": lambda one: str(one.figures["verdict"]),
        **EXPECTED,
        "written": lambda one: "-" if one.error else str(written[one.session]),
        "reasons": _reasons,
    }
    return over_sessions(args, jobs, console, columns)


def _reasons(one: Ended[Figures]) -> str:
    """The first, and how many more there are."""
    figures: Mapping[str, Any] = one.figures
    return list_reasons(figures["reasons"], 1)


def _calibrate(
    folder: Path,
    console: Console,
    *,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    manual: Path | None,
    train: Sequence[int],
    test: Sequence[int],
    weight_kg: float | None,
    rezero: bool,
    force: bool,
    out: Path,
    report: Path | None,
) -> Figures:
    """Calibrate; a calibration with the verdict FAIL is not written."""
    session = Session.open(folder, force=force)
    known = None if manual is None else load_calibration(manual)
    outcome = calibrate_session(
        session, train, test, settings, tolerances,
        manual=known, weight_kg=weight_kg, rezero=rezero,
    )  # fmt: skip
    say(console, weight_line(outcome.data.weighed, outcome.data.robot))
    print_table(console, errors_table(_against(outcome), stages_rows(outcome.modelled)))
    _print_channels(outcome, console)
    if zeros := outcome.zeros:
        print_table(console, of_page(zeros_table(zeros)))
    _print_deviations(outcome, console)
    _print_trust(outcome, console)
    calibration = outcome.calibration
    if calibration.verdict != "FAIL":
        save_calibration(calibration, out)
    if report is not None:
        # Matplotlib takes a second to load, which most calls need not wait for.
        from shoecal_core.report.calibration.report import calibration_report  # noqa: PLC0415
        from shoecal_core.report.calibration.session_report import session_content  # noqa: PLC0415

        calibration_report(report, session_content(session, outcome))
    figures = to_json(outcome)
    require_usable(calibration, figures, console)
    say(console, f"{out}")
    say(console, after_calibration(calibration.verdict, str(out)))
    return Figures(figures)


def to_json(outcome: CalibrationOutcome) -> dict[str, object]:
    """Figures of a calibration for machines."""
    calibration, fit = outcome.calibration, outcome.stages.fit
    return {
        "format": 1,
        "verdict": calibration.verdict,
        "method": JOINT if outcome.joint is not None else PAPER,
        "reasons": list(calibration.reasons),
        "train": list(outcome.train),
        "test": list(outcome.test),
        "against_model": {
            stage: {name: found.to_json() for name, found in sets.items()}
            for stage, sets in outcome.modelled.items()
        },
        "channels": {
            name: {"gain": float(gain), "offset_n": float(offset)}
            for name, gain, offset in zip(
                calibration.channels,
                calibration.parameters.gain,
                calibration.parameters.offset,
                strict=True,
            )
        },
        "assessment": outcome.assessment.to_json(outcome.data.shoe),
        "weight": weight_json(outcome.data.weighed, outcome.data.robot),
        "zeros": outcome.zeros,
        "model_limit": {name: limit.to_json() for name, limit in outcome.limits.items()},
        "screening": outcome.screening.to_json(),
        "time_offset_s": calibration.time_offset,
        "deviations": [] if outcome.joint is None else deviations_json(outcome.joint),
        "initial_guess": {
            "cop_rows": _guess(outcome.stages.guess),
            "cop_and_weight_rows": _guess(outcome.stages.guess_with_weight),
        },
        "rank": fit.rank,
        "singular_values": fit.singular_values.tolist(),
        "cost": fit.cost,
        "gradient_norm": fit.gradient_norm,
    }


def _guess(guess: InitialGuess) -> dict[str, float | None]:
    """Its common gain and offset; null where each channel has its own."""
    return {
        name: value if math.isfinite(value) else None
        for name, value in (("gain", guess.gain), ("offset_n", guess.offset))
    }


def deviations_json(joint: JointFit) -> list[dict[str, object]]:
    """Every deviation of robot and shoes as it was fitted, SI units."""
    return [
        {
            "effect": one.deviation.effect,
            "location": list(one.deviation.location),
            "component": one.deviation.component,
            "run": one.deviation.run,
            "unit": one.deviation.unit,
            "value": one.value,
            "std": one.std,
            "as_built_std": one.deviation.std,
        }
        for one in joint.deviations
    ]


def _print_deviations(outcome: CalibrationOutcome, console: Console) -> None:
    """Deviations of robot and shoes that are significant."""
    if outcome.joint is None:
        return
    sure = [
        f"{one.deviation.effect} {' '.join(one.deviation.location)} {one.deviation.component} "
        f"{one.value:.2g} ± {one.std:.2g} {one.deviation.unit}".rstrip()
        for one in outcome.joint.deviations
        if one.deviation.run is None and abs(one.value) > SURE * one.std
    ]
    listed = "; ".join(sure) or "none"
    say(console, f"  differs from the files (significant): {listed}")


def _print_trust(outcome: CalibrationOutcome, console: Console) -> None:
    console.print()
    print_table(console, of_page(expected_table(outcome.assessment)))
    for line in trust_lines(outcome.assessment, outcome.screening):
        say(console, f"  {line}")
    lost = left_out_table(outcome.screening)
    if lost is not None and outcome.screening.findings:
        console.print()
        print_table(console, of_page(lost))


def _print_channels(outcome: CalibrationOutcome, console: Console) -> None:
    """Gains and offsets; ± is half of the 95 % interval, as in the report."""
    calibration, shoe = outcome.calibration, outcome.data.shoe
    parameters, half = calibration.parameters, outcome.assessment.interval()
    count = len(shoe.names)
    table = new_table("Channels (± half of the 95 % interval)")
    table.add_column("", no_wrap=True)
    for name in ("gain", "offset"):
        table.add_column(name, justify="right", no_wrap=True)
    for index, name in enumerate(shoe.names):
        unit, gain_unit = channel_units(shoe, torque=bool(shoe.torque[index]))
        table.add_row(
            name,
            uncertain(parameters.gain[index], half[index], gain_unit),
            uncertain(parameters.offset[index], half[count + index], unit),
        )
    print_table(console, table)
    late = uncertain(1e3 * calibration.time_offset, 1e3 * half[-1], "ms")
    say(console, f"  time offset (joints after readings) {late}")
