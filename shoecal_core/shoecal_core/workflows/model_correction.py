"""What was found of the robot itself, in its files, and whether they gain by it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import ALL
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import FieldError
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import Errors, Series, errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.files import atomic_write, read_bytes
from shoecal_core.progress import Progress, no_progress
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import ROBOT, URDF, Session
from shoecal_core.robot.correction import ModelCorrection, corrected_urdf
from shoecal_core.robot.mjcf import corrected_mjcf
from shoecal_core.robot.randomisation import (
    COM,
    COMPLIANCE,
    JOINT_ZERO,
    LATENCY,
    MASS,
    PLAY,
    Parameter,
    Randomisation,
)
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import read_urdf
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.calibrate import calibrate_session

FITTED = frozenset(("joint_offset", "link_mass", "link_com"))
"""Effects of a fit that a URDF can hold."""
FOLDS = 4
"""Of a cross-validation."""
MJCF, RANDOMISATION = "robot.xml", "randomisation.yaml"
_RELATIVE = re.compile(r'<mesh\s[^>]*?filename="(?![/\\]|\w+:)([^"]+)"')
"""A mesh that a URDF looks for from its own folder."""
_URDF_LINE = re.compile(r"^urdf:.*$", re.MULTILINE)
_WEIGHT = r"^(weight:(?:(?!^\S).)*?{key}:\s*)([-+.0-9eE]+)"


@dataclass(frozen=True)
class Found:
    """One number by which a robot is off its files.

    Attributes:
        effect, location, component, unit: as in a diagnosis; `link_mass` is a share.
        value, std: of its posterior, in its unit.
    """

    effect: str
    location: tuple[str, ...]
    component: str
    unit: str
    value: float
    std: float


@dataclass(frozen=True)
class Corrected:
    """Copies of a robot's files with what was found in them.

    Attributes:
        files: text of each, by name.
        found: all that is in them.
        left: what a file has no place for, in words.
    """

    files: Mapping[str, str]
    found: tuple[Found, ...]
    left: tuple[str, ...] = ()


@dataclass(frozen=True)
class CorrectedRobot:
    """Files of a session's robot with what a fit found in them, and what they are worth.

    Attributes:
        corrected: joint zeros [rad], shares of mass, shifts of CoMs [m], all of them.
        runs: that the errors are of.
        before, after: of calibrations against the model of the session's files and of corrected
            ones, on runs that were not fitted: the test runs, or, where there is none, all runs in
            `FOLDS` parts, each by what the others found.
    """

    corrected: Corrected
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
    mjcf: Path | None = None,
    progress: Progress = no_progress,
) -> CorrectedRobot:
    """Joint zeros and masses that a session finds, in copies of its robot file and URDF.

    Args:
        session: recorded at rest.
        train, test: runs; see `split_runs`.
        settings, tolerances: of the fit.
        mjcf: of the same robot, to be corrected too.
        progress: see `Progress`.

    Raises:
        SessionError: of a session whose calibration fails its checks, or of a walk, whose fit
            holds no errors of the robot.
        FieldError: where `urdf` has no line of its own in the robot file.
        MjcfError: of an MJCF that is not of this robot.
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
        corrected=corrected_files(session, found, mjcf),
        runs=tuple(sorted(run for _, runs in held_out for run in runs)),
        before=errors(pairs[0]),
        after=errors(pairs[1]),
    )


def _found(session: Session, outcome: CalibrationOutcome) -> tuple[Found, ...]:
    if outcome.joint is None:
        raise SessionError(
            session.folder,
            "is of a walk, in which joint zeros and masses are not identifiable; record double "
            "supports",
        )
    return tuple(
        Found(of.effect, of.location, of.component, of.unit, one.value, one.std)
        for one in outcome.joint.deviations
        if (of := one.deviation).effect in FITTED and of.run is None
    )


def _corrected(session: Session, outcome: CalibrationOutcome) -> Robot:
    """A session's robot, shoes on, with what was found in it."""
    with TemporaryDirectory() as folder:
        for name, text in corrected_files(session, _found(session, outcome)).files.items():
            atomic_write(Path(folder) / name, text)
        return load_robot(Path(folder) / ROBOT, session.shoe)


def corrected_files(
    session: Session, found: Sequence[Found], mjcf: Path | None = None
) -> Corrected:
    """Copies of a session's robot file and URDF, and of an MJCF, and what to randomise.

    Args:
        session: whose files are nominal.
        found: of the session's robot.
        mjcf: of the same robot.
    """
    shod, bare = (load_robot(session.robot_yaml, shoe) for shoe in (session.shoe, None))
    correction = model_correction(found, shod, bare)
    files = {
        URDF: corrected_urdf(_text(session.robot_urdf), bare, correction),
        ROBOT: _weighing(session.robot_yaml, _naming(session.robot_yaml, URDF), found),
        RANDOMISATION: _randomisation(found, shod, bare, correction).text(),
    }
    left = _meshes_left(files[URDF])
    if mjcf is not None:
        files[MJCF], without = corrected_mjcf(mjcf, bare, correction)
        left += without
    return Corrected(files, tuple(found), left)


def model_correction(found: Sequence[Found], robot: Robot, bare: Robot) -> ModelCorrection:
    """The change of files that makes their robot the one that was found.

    All values are used, small ones too: they were found together, and trade with each other. The
    total mass stays, but for `payload` and `total_mass`.

    Args:
        found: of robot with shoes.
        robot: the same, shoes on.
        bare: without shoes: what was found of both, the URDF's links have to bear.
    """
    shod, own = _masses(robot), _masses(bare)
    masses, coms = dict(own), dict[str, FloatArray]()
    for one in found:
        name = one.location[0] if one.location else ""
        if one.effect == "link_mass":
            masses[name] += one.value * shod[name]
        elif one.effect == "link_com":
            moved = coms.setdefault(name, np.zeros(3))
            moved["xyz".index(one.component)] += one.value * shod[name] / own[name]
    total = sum(own.values())
    scale = total / sum(masses.values())
    masses = {name: scale * mass for name, mass in masses.items()}
    for one in found:
        if one.effect == "payload":
            masses[one.location[0]] += one.value
        elif one.effect == "total_mass":
            masses = {name: mass + one.value * own[name] / total for name, mass in masses.items()}
    return ModelCorrection(
        zeros=_of_joints(found, "joint_offset", robot),
        masses={name: mass / own[name] for name, mass in masses.items()},
        coms=coms,
        compliance=_of_joints(found, "joint_compliance", robot),
        play=_of_joints(found, "backlash", robot),
        latency=_of_feet(found),
    )


def _of_joints(
    found: Sequence[Found], effect: str, robot: Robot, *, std: bool = False
) -> dict[str, float]:
    """Values or standard deviations of one effect by joint; `all` are those that are planned with.

    A joint on another one's motor has that one's zero, in proportion, and its own gear.
    """
    values: dict[str, float] = {}
    for one in found:
        if one.effect == effect:
            names = _legs(robot) if one.location == (ALL,) else one.location
            values |= dict.fromkeys(names, one.std if std else one.value)
    if effect == "joint_offset":
        for shared in robot.shared:
            leader = robot.joint_names[shared.leader]
            if leader in values:
                ratio = abs(shared.ratio) if std else shared.ratio
                values[robot.joint_names[shared.joint]] = ratio * values[leader]
    return values


def _legs(robot: Robot) -> list[str]:
    return [robot.joint_names[index] for index in robot.moved]


def _of_feet(found: Sequence[Found], *, std: bool = False) -> dict[str, float]:
    values: dict[str, float] = {}
    for one in found:
        if one.effect == "latency":
            feet = FEET if one.location == (ALL,) else one.location
            values |= dict.fromkeys(feet, one.std if std else one.value)
    return values


def _randomisation(
    found: Sequence[Found], robot: Robot, bare: Robot, correction: ModelCorrection
) -> Randomisation:
    """Posterior of all that was found, by what is to be added to the nominal files."""
    parameters: list[Parameter] = []
    for kind, effect, means in (
        (JOINT_ZERO, "joint_offset", correction.zeros),
        (COMPLIANCE, "joint_compliance", correction.compliance),
        (PLAY, "backlash", correction.play),
    ):
        stds = _of_joints(found, effect, robot, std=True)
        parameters += [Parameter(kind, name, means[name], stds[name]) for name in means]
    late = _of_feet(found, std=True)
    parameters += [
        Parameter(LATENCY, name, mean, late[name]) for name, mean in correction.latency.items()
    ]
    shod, own = _masses(robot), _masses(bare)
    # A robot file's weight scales the URDF's links: what is added is added to the URDF's.
    declared = read_urdf(bare.urdf).model.inertias
    total = sum(own.values())
    scale = sum(one.mass for one in declared) / total
    for name, factor in correction.masses.items():
        std = np.sqrt(sum(_mass_std(one, name, shod, own) ** 2 for one in found))
        if factor != 1.0 or std > 0.0:
            mean = (factor - 1.0) * own[name] * scale
            parameters.append(Parameter(MASS, name, float(mean), float(scale * std)))
    for name, moved in correction.coms.items():
        stds = {
            one.component: one.std * shod[name] / own[name]
            for one in found
            if one.effect == "link_com" and one.location == (name,)
        }
        parameters += [
            Parameter(COM["xyz".index(axis)], name, float(moved["xyz".index(axis)]), std)
            for axis, std in stds.items()
        ]
    return Randomisation(robot.name, tuple(parameters))


def _mass_std(one: Found, name: str, shod: Mapping[str, float], own: Mapping[str, float]) -> float:
    """What one number leaves open of one link's mass [kg]."""
    if one.effect == "total_mass":
        return one.std * own[name] / sum(own.values())
    if one.location != (name,):
        return 0.0
    return {"link_mass": shod[name], "payload": 1.0}.get(one.effect, 0.0) * one.std


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


def _weighing(path: Path, text: str, found: Sequence[Found]) -> str:
    """A robot file's text with the weight, and its uncertainty, of what it carries."""
    added = [one for one in found if one.effect in ("payload", "total_mass")]
    if not added:
        return text
    mass, std = sum(one.value for one in added), float(np.linalg.norm([one.std for one in added]))
    for key in ("mass_kg", "std_kg"):
        match = re.search(_WEIGHT.format(key=key), text, re.MULTILINE | re.DOTALL)
        if match is None:
            raise FieldError(path, "must be a number below `weight`", field=f"weight.{key}")
        old = float(match[2])
        new = old + mass if key == "mass_kg" else float(np.hypot(old, std))
        text = f"{text[: match.start(2)]}{new:.6g}{text[match.end(2) :]}"
    return text


def _meshes_left(urdf: str) -> tuple[str, ...]:
    """In words, that a copy of a URDF does not find meshes in another folder; else nothing."""
    if (mesh := _RELATIVE.search(urdf)) is None:
        return ()
    where = f"{URDF} names them from its folder ({mesh[1]}), as the original does"
    return (f"meshes: {where}; copy it next to that one to see them",)


def _text(path: Path) -> str:
    return read_bytes(path).decode("utf-8", errors="replace")
