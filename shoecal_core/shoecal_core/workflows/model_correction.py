"""What a joint fit found of the robot itself, and whether the robot's files gain by it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FieldError
from shoecal_core.estimation.joint_fit import FittedDeviation
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import (
    Errors,
    Series,
    errors,
    measured_series,
    modelled_series,
)
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import atomic_write, read_bytes
from shoecal_core.progress import Progress, no_progress
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import ROBOT, URDF, Session
from shoecal_core.robot.correction import ModelCorrection, corrected_urdf
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.workflows.calibrate import calibrate_session

JOINT_ZERO, MASS, COM = "joint_offset", "link_mass", "link_com"
"""Effects of a fit that a URDF can hold."""
FOLDS = 4
"""Of a cross-validation."""
_URDF_LINE = re.compile(r"^urdf:.*$", re.MULTILINE)


@dataclass(frozen=True)
class CorrectedRobot:
    """Files of a session's robot with what a fit found in them, and what they are worth.

    Attributes:
        files: text of robot file and URDF, by name.
        found: joint zeros [rad], shares of mass, shifts of CoMs [m], all of them.
        runs: that the errors are of.
        before, after: of calibrations against the model of the session's files and of corrected
            ones, on runs that were not fitted: the test runs, or, where there is none, all runs in
            `FOLDS` parts, each by what the others found.
    """

    files: Mapping[str, str]
    found: tuple[FittedDeviation, ...]
    runs: tuple[int, ...]
    before: Errors
    after: Errors

    @property
    def better(self) -> bool:
        """Whether the corrected model's CoP is nearer to the measured one."""
        return self.after.cop.mean < self.before.cop.mean


def correct_robot(
    session: Session,
    train: Sequence[int],
    test: Sequence[int],
    settings: CalibrationSettings,
    tolerances: Tolerances,
    progress: Progress = no_progress,
) -> CorrectedRobot:
    """Joint zeros and masses that a session finds, in copies of its robot file and URDF.

    Args:
        session: recorded at rest.
        train, test: runs; see `split_runs`.
        settings, tolerances: of the fit.
        progress: see `Progress`.

    Raises:
        SessionError: of a session whose calibration fails its checks, or of a walk, whose fit
            holds no errors of the robot.
        FieldError: where `urdf` has no line of its own in the robot file.
    """
    progress("fitting all runs", 0.0)
    outcome = calibrate_session(session, train, test, settings, tolerances)
    if outcome.calibration.verdict == "FAIL":
        reasons = list_reasons(outcome.calibration.reasons, 1)
        raise SessionError(session.folder, f"no fit to correct the robot by: {reasons}")
    found = _found(session, outcome)
    held_out = [(outcome, outcome.test)]
    if not outcome.test:
        held_out = []
        for fold in range(FOLDS):
            runs = outcome.train[fold::FOLDS]
            rest = [run for run in outcome.train if run not in runs]
            if runs:
                progress(f"part {fold + 1} of {FOLDS} held out", (fold + 1) / (FOLDS + 1))
                fitted = calibrate_session(session, rest, runs, settings, tolerances)
                held_out.append((fitted, runs))
    pairs: tuple[list[tuple[Series, Series]], ...] = ([], [])
    for fitted, runs in held_out:
        sensing = fitted.calibration.sensing(session.shoe)
        for robot, compared in zip((None, _corrected(session, fitted)), pairs, strict=True):
            data = load_data(session, runs, settings, robot=robot)
            compared += [
                (measured_series(sensing, one), modelled_series(one)) for one in data.of(runs)
            ]
    return CorrectedRobot(
        files=_files(session, found),
        found=found,
        runs=tuple(sorted(run for _, runs in held_out for run in runs)),
        before=errors(pairs[0]),
        after=errors(pairs[1]),
    )


def _found(session: Session, outcome: CalibrationOutcome) -> tuple[FittedDeviation, ...]:
    if outcome.joint is None:
        raise SessionError(
            session.folder,
            "is of a walk, in which joint zeros and masses are not identifiable; record double "
            "supports",
        )
    return tuple(
        one
        for one in outcome.joint.deviations
        if one.deviation.effect in {JOINT_ZERO, MASS, COM} and one.deviation.run is None
    )


def _corrected(session: Session, outcome: CalibrationOutcome) -> Robot:
    """A session's robot, shoes on, with what was found in it."""
    with TemporaryDirectory() as folder:
        for name, text in _files(session, _found(session, outcome)).items():
            atomic_write(Path(folder) / name, text)
        return load_robot(Path(folder) / ROBOT, session.shoe)


def _files(session: Session, found: Sequence[FittedDeviation]) -> dict[str, str]:
    shod, bare = (load_robot(session.robot_yaml, shoe) for shoe in (session.shoe, None))
    correction = model_correction(found, shod, bare)
    return {
        URDF: corrected_urdf(_text(session.robot_urdf), bare, correction),
        ROBOT: _naming(session.robot_yaml, URDF),
    }


def model_correction(
    found: Sequence[FittedDeviation], robot: Robot, bare: Robot
) -> ModelCorrection:
    """The change of a URDF that makes its robot the one of a fit; the total mass stays.

    All values are used, small ones too: they were found together, and trade with each other.

    Args:
        found: joint zeros, shares of mass and shifts of CoMs.
        robot: that was fitted, shoes on.
        bare: the same without shoes: what a fit found of both, the URDF's links have to bear.
    """
    zeros: dict[str, float] = {}
    shares: dict[str, float] = {}
    coms: dict[str, NDArray[np.float64]] = {}
    for one in found:
        name = one.deviation.location[0]
        if one.deviation.effect == JOINT_ZERO:
            zeros[name] = one.value
        elif one.deviation.effect == MASS:
            shares[name] = one.value
        else:
            coms.setdefault(name, np.zeros(3))["xyz".index(one.deviation.component)] = one.value
    for shared in robot.shared:
        leader = robot.joint_names[shared.leader]
        if leader in zeros:
            zeros[robot.joint_names[shared.joint]] = shared.ratio * zeros[leader]
    shod, own = _masses(robot), _masses(bare)
    masses = {name: mass + shares.get(name, 0.0) * shod[name] for name, mass in own.items()}
    scale = sum(own.values()) / sum(masses.values())
    return ModelCorrection(
        zeros=zeros,
        masses={name: scale * mass / own[name] for name, mass in masses.items()},
        coms={name: shod[name] / own[name] * shift for name, shift in coms.items()},
    )


def _masses(robot: Robot) -> dict[str, float]:
    """Of each joint's links together, by the name of the first [kg]."""
    model = robot.model
    return {
        str(first_link(model, joint).name): float(model.inertias[joint].mass)
        for joint in range(1, model.njoints)
        if model.inertias[joint].mass > 0.0
    }


def _naming(robot_yaml: Path, urdf: str) -> str:
    """A robot file's text with another URDF."""
    text, count = _URDF_LINE.subn(f"urdf: {urdf}", _text(robot_yaml))
    if count != 1:
        raise FieldError(robot_yaml, "must stand on a line of its own", field="urdf")
    return text


def _text(path: Path) -> str:
    return read_bytes(path).decode("utf-8", errors="replace")
