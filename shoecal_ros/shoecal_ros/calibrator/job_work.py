"""What the calibrator's worker process does for its jobs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.diagnosis.possible_motions import stance
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration, save_calibration
from shoecal_core.files import atomic_write
from shoecal_core.planning.motion_sets import (
    MOTION_SETS,
    STANDARD_SUPPORTS,
    TEST,
    THOROUGH,
    TRAIN,
    PlannedRun,
    listed_runs,
    set_runs,
)
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.recording.session import RunEntry, Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_ros.calibrator.proposals import planned_as, proposal
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Link

CALIBRATION = "calibration.yaml"
JSON, REPORT = "diagnosis.json", "diagnosis.html"
LEAST_TRAIN = 2
"""Runs that must be left to train before one is kept for the test."""


@dataclass(frozen=True)
class WrittenDiagnosis:
    """A diagnosis, and where it was written down.

    Attributes:
        verdict: what it comes to.
        json: the whole of it.
        report: HTML file.
        proposed: motion that would separate the causes best; empty: none.
        separates: what it separates.
    """

    verdict: str
    json: str
    report: Path
    proposed: str
    separates: tuple[str, ...]


def calibration_runs(
    link: Link,
    files: RobotFiles,
    settings: PlannerSettings,
    motion: str,
    count: int,
    train: int,
    seed: int,
) -> list[PlannedRun]:
    """What a self-calibration does where.

    Args:
        link: to the node.
        files: robot and shoe.
        settings: of planning.
        motion: a set of motions, or one motion of the planner's catalogue for each support.
        count: double supports to draw.
        train: of them that one motion trains in; a set says that itself.
        seed: draws the double supports, and which of them train.
    """
    del link
    robot, shoe = files.load_robot(), files.load_shoe()
    supports = draw_supports(robot, shoe, settings, count, seed)
    if motion in MOTION_SETS:
        return list(set_runs(motion, supports, robot.neutral))
    training = np.random.default_rng([seed, 2]).choice(count, size=train, replace=False)
    return [
        PlannedRun(support, motion, TRAIN if index in training else TEST)
        for index, support in enumerate(supports)
    ]


@dataclass(frozen=True)
class Reached:
    """How good a calibration the runs recorded so far give.

    Attributes:
        cop: the larger expected CoP error of a foot [m]; infinite while there is no calibration.
        message: the same for a person, with what another run would win.
    """

    cop: float
    message: str


def reached(
    link: Link,
    folder: Path,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    manual: Calibration | None,
) -> Reached:
    """What the runs of a session give by now; arguments as of `solve`."""
    del link
    try:
        outcome = calibrate_session(
            Session.open(folder), settings=settings, tolerances=tolerances, manual=manual
        )
    except ShoecalError as error:
        return Reached(np.inf, f"no calibration yet: {error}")
    if outcome.calibration.verdict == "FAIL":
        return Reached(np.inf, f"no calibration yet: {list_reasons(outcome.calibration.reasons)}")
    _, feet = outcome.assessment.expected_cop()
    _, then = outcome.assessment.expected_cop_with_another()
    now, next_ = max(feet.values()), max(then.values())
    return Reached(
        now,
        f"expected CoP error of a foot {1e3 * now:.1f} mm; the best of these runs once more would "
        f"make that {1e3 * next_:.1f} mm",
    )


def solve(
    link: Link,
    folder: Path,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    made_ns: int,
    manual: Calibration | None,
) -> Calibration:
    """The calibration that a session gives; it is kept in the session's folder, too.

    Args:
        link: to the node.
        folder: of the session.
        settings, tolerances: of the fit.
        made_ns: time stamp of the calibration [ns since the epoch].
        manual: calibration of these shoes with known weights, as a prior.
    """
    del link
    calibration = calibrate_session(
        Session.open(folder),
        settings=settings,
        tolerances=tolerances,
        made_ns=made_ns,
        manual=manual,
    ).calibration
    save_calibration(calibration, folder / CALIBRATION)
    return calibration


def runs_to_record(
    link: Link,
    files: RobotFiles,
    settings: PlannerSettings,
    motions: Sequence[str],
    seed: int,
    session: Path | None,
) -> list[PlannedRun]:
    """Which motion in which double support.

    Args:
        link: to the node.
        files: robot and shoe.
        settings: of planning.
        motions: of the planner's catalogue or proposed; none: the thorough set.
        seed: draws the double supports.
        session: to add to: what is added trains, in the double supports that are there already.
            Of a new one the last quarter tests.
    """
    del link
    robot, shoe = files.load_robot(), files.load_shoe()
    entries = () if session is None else Session.open(session).runs
    so_far = _supports(entries)
    if not motions:
        drawn = draw_supports(robot, shoe, settings, STANDARD_SUPPORTS, seed)
        return list(set_runs(THOROUGH, drawn, robot.neutral))
    count = min(len(motions), STANDARD_SUPPORTS)
    places = so_far or draw_supports(robot, shoe, settings, count, seed)
    runs = listed_runs(places, [planned_as(name) for name in motions])
    hints = _marks(len(motions)) if session is None else [_mark_with(entries)] * len(motions)
    feasible = Feasible(robot, settings)
    # A run bears the name that it was asked for by: the recording shows what was done by hand.
    return [
        PlannedRun(
            stance(where, feasible, so_far) if (where := proposal(name).stance) else run.support,
            name,
            hint,
        )
        for run, name, hint in zip(runs, motions, hints, strict=True)
    ]


def diagnose_session(
    link: Link, folder: Path, settings: DiagnosisSettings, tolerances: Tolerances
) -> WrittenDiagnosis:
    """Diagnose a session; JSON and report are kept in its folder."""
    # Simulator and pictures come along: the node itself stays lean.
    from shoecal_core.workflows.diagnose import DiagnosisRequest, do  # noqa: PLC0415

    job = DiagnosisRequest(folder, settings, tolerances, report=folder / REPORT)
    done = do(job, lambda doing, share: link.progress((doing, share)))
    found = done.diagnosis
    assert found is not None, "else it has raised"
    text = json.dumps(done.to_json(), indent=1, allow_nan=False)
    atomic_write(folder / JSON, text + "\n")
    following = found.next_motion
    return WrittenDiagnosis(
        verdict=found.verdict,
        json=text,
        report=folder / REPORT,
        proposed="" if following is None else following.motion,
        separates=() if following is None else tuple(following.separates),
    )


def _marks(count: int) -> list[str]:
    """What listed runs are meant for: the last quarter tests, of three runs the last one."""
    tests = max(count // 4, 1 if count > LEAST_TRAIN else 0)
    return [TRAIN] * (count - tests) + [TEST] * tests if tests else [""] * count


def _mark_with(entries: Sequence[RunEntry]) -> str:
    """What a run added to others is meant for: to train, unless unmarked ones do all."""
    return TRAIN if any(entry.hint for entry in entries) else ""


def _supports(entries: Sequence[RunEntry]) -> list[DoubleSupport]:
    """Double supports of a session's runs, those that train first, each once."""
    runs = sorted(entries, key=lambda entry: entry.hint != TRAIN)
    return list(dict.fromkeys(entry.info.support for entry in runs if entry.info.support))
