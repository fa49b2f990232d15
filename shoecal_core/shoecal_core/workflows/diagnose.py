"""The diagnosis of one session as a job that another process can do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.result import Diagnosis
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.base import Effect
from shoecal_core.error_sources.effects.known import EFFECTS, effects_from
from shoecal_core.error_sources.known_places import known_places
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.series import errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.progress import Progress, no_progress
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.report.origin import origin
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.zeros import ZeroFigures, zeros_json
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.evaluation import load_calibration_of

READ_TO, SIMULATED_FROM = 0.1, 0.7
"""Share of the work in which runs are read, and after which the found effects are simulated."""


@dataclass(frozen=True)
class DiagnosisRequest:
    """What to diagnose, and how.

    Attributes:
        session: its folder.
        settings, tolerances: of the diagnosis.
        screening: settings by which the runs are screened for notes and the calibration's own gap.
        calibration: file of one whose own gap is reported as well; None: none.
        weight_kg: of robot and shoes, in place of the robot file's; None: that.
        rezero: whether each run is taken with its own zeros.
        train, test: runs; empty: as the session marks them.
        without: signals that are not used: closure, parity, tilt, air.
        only: effects that are looked for, each with the place it is looked for at (empty: at
            all of its places); nothing: all.
        effects_from: a Python file with more effects.
        simulate: whether the found effects are simulated.
        force: read runs though robot or shoe file was changed since.
        report: HTML file to write.
    """

    session: Path
    settings: DiagnosisSettings = field(default_factory=DiagnosisSettings)
    tolerances: Tolerances = field(default_factory=Tolerances)
    screening: CalibrationSettings = field(default_factory=CalibrationSettings)
    calibration: Path | None = None
    weight_kg: float | None = None
    rezero: bool = False
    train: tuple[int, ...] = ()
    test: tuple[int, ...] = ()
    without: frozenset[str] = frozenset()
    only: tuple[tuple[str, tuple[str, ...]], ...] = ()
    effects_from: Path | None = None
    simulate: bool = True
    force: bool = False
    report: Path | None = None

    def wanted(self, effect: str, place: tuple[str, ...]) -> bool:
        """Whether an effect is looked for at a place."""
        return any(effect == name and where in ((), place) for name, where in self.only)


@dataclass(frozen=True)
class CalibratedGap:
    """What a calibration leaves between measurement and model on the test runs.

    Attributes:
        id: of the calibration.
        cop_mae_mm, grf_mae_n: mean errors.
    """

    id: str
    cop_mae_mm: float
    grf_mae_n: float


@dataclass(frozen=True)
class Diagnosed:
    """What came of a request.

    Attributes:
        session: folder.
        diagnosis: without its evidence, which the report has used up.
        calibrated: of the calibration that was named.
        zeros: what each foot reads in the air, run by run.
    """

    session: Path
    diagnosis: Diagnosis
    calibrated: CalibratedGap | None = None
    zeros: list[ZeroFigures] = field(default_factory=list)

    def to_json(self) -> dict[str, object]:
        """For programs."""
        result = {"session": str(self.session), **self.diagnosis.to_json(), "zeros": self.zeros}
        if self.calibrated is not None:
            result["calibration"] = vars(self.calibrated).copy()
        return result


def do(job: DiagnosisRequest, progress: Progress = no_progress) -> Diagnosed:
    """Diagnose, simulate what was found, and write the report.

    Raises:
        ShoecalError: for a session, a calibration or an option that cannot be used.
    """
    session = Session.open(job.session, force=job.force)
    effects = _library(job.effects_from)
    known = [effect.identifier for effect in effects]
    for name, _ in job.only:
        if name not in known:
            raise NameNotFoundError("effect", name, known)
    _check_places(job, session)
    calibration = None
    if job.calibration is not None:
        calibration = load_calibration_of(job.calibration, session)
    train, test = split_runs(session, job.train, job.test)
    data = load_data(
        session,
        (*train, *test),
        job.screening,
        weight_kg=job.weight_kg,
        all_readable=False,
        progress=lambda text, share: progress(text, READ_TO * share),
    )
    if data.problems and not data.runs.keys() & set(train):
        reasons = "; ".join(dict.fromkeys(data.problems.values()))
        problem = f"none of the training runs can be used: {reasons}"
        raise SessionError(session.folder, problem)
    found = diagnose(
        session,
        train,
        test,
        job.settings,
        job.tolerances,
        weight_kg=job.weight_kg,
        rezero=job.rezero,
        without=job.without,
        only=job.wanted if job.only else None,
        effects=effects,
        data=data,
        progress=lambda text, share: progress(text, max(READ_TO, SIMULATED_FROM * share)),
    )
    if job.simulate and found.named:
        # A physics engine, which most calls do not need.
        from shoecal_core.workflows.simulated_shrink import (  # noqa: PLC0415
            with_simulated_shrink,
        )

        progress("simulating what was found", SIMULATED_FROM)
        found = with_simulated_shrink(found, data, job.screening)
    found = replace(found, notes=(*found.notes, *_checked(data)))
    if job.report is not None:
        # Matplotlib takes a second to load, which most calls need not wait for.
        from shoecal_core.report.diagnosis.report import write_diagnosis_report  # noqa: PLC0415

        provenance = (
            origin(session, (*found.train, *found.test)),
            f"Session folder {session.folder.name}.",
        )
        write_diagnosis_report(
            found, job.report, robot=data.robot, shoe=data.shoe, provenance=provenance
        )
    calibrated = None if calibration is None else _calibrated(calibration, data, found.test)
    progress("done", 1.0)
    parameters = None if calibration is None else calibration.parameters
    return Diagnosed(
        job.session,
        replace(found, evidence=None),
        calibrated,
        zeros=zeros_json(session.shoe, found.zeros, parameters),
    )


def _library(own: Path | None) -> tuple[Effect, ...]:
    """All effects that are known, and those of a file."""
    return EFFECTS if own is None else (*EFFECTS, *effects_from(own))


def _check_places(job: DiagnosisRequest, session: Session) -> None:
    """Refuse places that this robot and these shoes have not, of effects of the library."""
    library = {effect.identifier: effect for effect in EFFECTS}
    asked = [(library[name], place) for name, place in job.only if place and name in library]
    if not asked:
        return
    robot = load_robot(session.robot_yaml, session.shoe, weight_kg=job.weight_kg)
    for effect, place in asked:
        known, name = list(known_places(effect, robot, session.shoe)), effect.identifier
        if known == [()]:
            raise ShoecalError(f"{name} has no place: ask for '{name}', without a colon")
        if place not in known:
            listed = [",".join(one) for one in known]
            raise NameNotFoundError(f"place of {name}", ",".join(place), listed)


def _checked(data: SessionData) -> list[str]:
    """What `check` finds in the runs: none of it is left out of a diagnosis, as it may be a cause.

    Without the samples that it leaves out, of which every session has some.
    """
    found = [one.reason for one in data.screening.findings if one.verdict != "PASS"]
    problems = [reason for run, reason in data.problems.items() if run in data.runs]
    return [f"check: {reason}" for reason in (*problems, *found)]


def _calibrated(calibration: Calibration, data: SessionData, test: Sequence[int]) -> CalibratedGap:
    sensing = calibration.sensing(data.shoe)
    found = errors(
        [(measured_series(sensing, stance), modelled_series(stance)) for stance in data.of(test)]
    )
    return CalibratedGap(calibration.id, 1e3 * found.cop.mean, found.grf.mean)
