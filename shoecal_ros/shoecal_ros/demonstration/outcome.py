"""What a demo found, against the simulated truth."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from shoecal_core.cli import tables
from shoecal_core.cli.prose import output, say
from shoecal_core.cli.tables import errors_table, reason_lines, stages_rows
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.estimation.comparison import compare, read_truths, stage_errors
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import Errors, errors
from shoecal_core.files import atomic_write, read_bytes
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import Truth, read_truth
from shoecal_core.report.calibration.report import calibration_report
from shoecal_core.report.calibration.session_report import session_content
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_ros.demonstration.options import Folder, Options


@dataclass(frozen=True)
class DemonstrationOutcome:
    """Everything to be shown.

    Attributes:
        session: recorded.
        outcome: of solving the recording again.
        stages: errors by stage and set.
        modelled: errors of the model over all runs.
        truths: by run.
    """

    session: Session
    outcome: CalibrationOutcome
    stages: dict[str, dict[str, Errors]]
    modelled: Errors
    truths: dict[int, Truth]


def split_truth(folder: Folder, session: Session) -> None:
    """Write each run's part of the truth next to the session's runs."""
    truth = read_truth(folder.truth)
    stamps = truth.start_ns + (1e9 * truth.time).round().astype(int)
    for entry in session.runs:
        run = session.read(entry.run)
        end_ns = run.start_ns + round(1e9 * max(run.joints.time[-1], run.readings.time[-1]))
        with session.new_truth(entry.info) as writer:
            for index in ((stamps >= run.start_ns) & (stamps <= end_ns)).nonzero()[0]:
                writer.write(
                    int(stamps[index]),
                    truth.cop[index],
                    truth.foot_cop[index],
                    truth.foot_grf[index],
                )
    drawn = folder.truth.with_suffix(".yaml")
    atomic_write(session.truth_path(1).parent / "reality.yaml", read_bytes(drawn))


def evaluate(
    folder: Folder, settings: CalibrationSettings, tolerances: Tolerances
) -> DemonstrationOutcome:
    """Solve the recording again and hold everything against the truth.

    Raises:
        ShoecalError: also when the recording does not give what the nodes found.
    """
    session = Session.open(folder.session)
    applied = load_calibration(folder.calibration)
    outcome = calibrate_session(
        session, settings=settings, tolerances=tolerances, made_ns=applied.made_ns
    )
    if outcome.calibration.id != applied.id:
        raise ShoecalError(
            f"{folder.session}: solved again it gives '{outcome.calibration.id}', the nodes found "
            f"'{applied.id}'; the recording is not what they saw"
        )
    truths = read_truths(session, outcome.data)
    comparisons = compare(outcome, truths)
    return DemonstrationOutcome(
        session=session,
        outcome=outcome,
        stages=stage_errors(comparisons),
        modelled=errors([(one.modelled, one.reference) for one in comparisons]),
        truths=truths,
    )


def write_results(
    folder: Folder, options: Options, found: DemonstrationOutcome, timing: Mapping[str, float]
) -> dict[str, object]:
    """Write result.json and report.html; the figures."""
    calibration = found.outcome.calibration
    hints = {entry.run: entry.hint for entry in found.session.runs}
    figures: dict[str, object] = {
        "format": 1,
        "robot": calibration.robot,
        "seed": options.seed,
        "verdict": calibration.verdict,
        "reasons": list(calibration.reasons),
        "supports": [
            {
                "run": entry.run,
                "dx": support.dx,
                "dy": support.dy,
                "dtheta": support.dtheta,
                "set": hints[entry.run],
            }
            for entry in found.session.runs
            if (support := entry.info.support) is not None
        ],
        "modelled": _json(found.modelled),
        **{
            stage: {name: _json(found_) for name, found_ in found.stages[stage].items()}
            for stage in ("initial_guess", "self_calibration")
        },
        "timing_s": {name: round(seconds, 2) for name, seconds in timing.items()},
    }
    atomic_write(folder.result, json.dumps(figures, indent=1, allow_nan=False) + "\n")
    calibration_report(
        folder.report,
        session_content(found.session, found.outcome, truths=found.truths, timing=timing),
    )
    return figures


def print_table(found: DemonstrationOutcome, timing: Mapping[str, float], folder: Folder) -> None:
    """A small table for the terminal."""
    console = output()
    rows = [("model, all runs", found.modelled)]
    stages = {name: sets for name, sets in found.stages.items() if name != "modelled"}
    table = errors_table("Errors against the simulated truth", rows + stages_rows(stages))
    tables.print_table(console, table)
    calibration = found.outcome.calibration
    for line in reason_lines(calibration):
        say(console, line)
    took = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in timing.items())
    say(console, took)
    say(console, f"{folder.out}: result.json, report.html, calibration.yaml, session/")


def _json(found: Errors) -> dict[str, float]:
    """Only what is known: JSON has no NaN."""
    return {name: value for name, value in found.to_json().items() if value == value}  # noqa: PLR0124
