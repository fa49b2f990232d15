"""The report on a calibration that was found from a recorded session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shoecal_core.estimation.comparison import StanceComparison, compare
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import Truth
from shoecal_core.report.calibration.content import CalibrationReport, RunReport
from shoecal_core.report.origin import origin

SNAPSHOTS = 6


def session_content(
    session: Session,
    outcome: CalibrationOutcome,
    *,
    truths: Mapping[int, Truth] | None = None,
    timing: Mapping[str, float] | None = None,
) -> CalibrationReport:
    """What the report on a calibration shows that `calibrate_session` found.

    Args:
        session: that the calibration was found from.
        outcome: of the calibration.
        truths: of simulated runs, to be compared with; of no use unless every run has one.
        timing: seconds by stage.

    Raises:
        FileError: when the session cannot be read any more.
    """
    by_run: dict[int, list[StanceComparison]] = {}
    known = truths or {}
    complete = known.keys() >= outcome.data.stances.keys()
    for one in compare(outcome, known if complete else {}):
        by_run.setdefault(one.stance.run, []).append(one)
    return CalibrationReport(
        robot=outcome.data.robot,
        shoe=outcome.data.shoe,
        calibration=outcome.calibration,
        stages=outcome.stages,
        runs=tuple(_run(outcome, stances) for stances in by_run.values()),
        assessed=outcome.assessment,
        screening=outcome.screening,
        timing=timing or {},
        provenance=_origin(session, outcome),
        zeros=tuple(outcome.zeros),
    )


def _run(outcome: CalibrationOutcome, stances: Sequence[StanceComparison]) -> RunReport:
    aligned = outcome.data.aligned[stances[0].stance.run]
    shown = np.linspace(0, len(aligned.time) - 1, SNAPSHOTS).round().astype(int)
    return RunReport(tuple(stances), aligned.time[shown], aligned.joint_angles[shown])


def _origin(session: Session, outcome: CalibrationOutcome) -> tuple[str, str]:
    recorded = origin(session, outcome.data.stances)
    return recorded, f"Session folder {session.folder.name}; {_listed(outcome)}."


def _listed(outcome: CalibrationOutcome) -> str:
    train, test = (", ".join(map(str, runs)) or "none" for runs in (outcome.train, outcome.test))
    return f"training runs: {train}; test runs: {test}"
