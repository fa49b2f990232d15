"""Whether a recorded session is fit for a calibration."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.recording.session import Session, missing_text
from shoecal_core.recording.train_test import split_runs
from shoecal_core.samples.zeros import ZeroFigures, zeros_json
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import split_reason
from shoecal_core.workflows.calibrate import calibrate_session


@dataclass(frozen=True)
class CheckedSession:
    """What is in a session.

    Attributes:
        data: of the runs that can be used.
        problems: what is in the way of a calibration, a line each.
        warnings: what is not, but should be looked at.
        zeros: what feet read in the air.
        outcome: of a calibration; None where there are problems before it.
    """

    data: SessionData
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    zeros: tuple[ZeroFigures, ...]
    outcome: CalibrationOutcome | None


def check_session(
    session: Session,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    *,
    weight_kg: float | None = None,
) -> CheckedSession:
    """Read every run, then calibrate: what `calibrate_session` refuses, this never passes.

    Zeros that change between runs do not make a session unfit: each run is judged with its own.

    Args:
        session: recorded.
        settings: weights of the fit.
        tolerances: of what the files of robot and shoes say.
        weight_kg: of robot and shoes, in place of the robot file's [kg].

    Raises:
        ShoecalError: when the files of robot or shoes cannot be used.
    """
    problems = [
        f"{path.name} was not finished: rescue it with `shoecal recover {path}`"
        for path in session.unfinished
    ] + ([missing_text(session.missing)] if session.missing else [])
    data = load_data(session, None, settings, weight_kg=weight_kg, all_readable=False)
    problems += data.problems.values()
    if not data.runs and not problems:
        problems.append(f"{session.folder}: no run can be read; record some")
    found = data.screening.findings
    problems += [one.reason for one in found if one.verdict == "FAIL"]
    warnings = [one.reason for one in found if one.verdict == "WARN"]
    outcome = None
    if not problems:
        train, test = split_runs(session, (), ())
        same = data if {*train, *test} == data.runs.keys() else None
        try:
            outcome = calibrate_session(
                session, train, test, settings, tolerances,
                weight_kg=weight_kg, rezero=True, data=same,
            )  # fmt: skip
        except ShoecalError as error:
            problems.append(str(error))
    if outcome is not None and outcome.calibration.verdict != "PASS":
        for level, text in (split_reason(one, "WARN") for one in outcome.calibration.reasons):
            if level == "FAIL":
                problems.append(text)
            elif level == "WARN" and text not in warnings:
                warnings.append(text)
    zeros = zeros_json(session.shoe, data.zeros) if outcome is None else outcome.zeros
    return CheckedSession(data, tuple(problems), tuple(warnings), tuple(zeros), outcome)
