"""Joint angles of imported recordings, compared with the URDF's limits and the trials' supports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from shoecal_core.errors import FieldError, FileError
from shoecal_core.files import read_yaml
from shoecal_core.recording import schemas
from shoecal_core.recording.columns import decode_columns
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.foreign import Floats, ImportedRun, MappedFiles
from shoecal_core.recording.limits import beyond_limits, in_degrees
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import read_outline
from shoecal_core.shoe.shoe import load_shoe

APART = {"dx": (0.05, "m"), "dy": (0.05, "m"), "dtheta": (0.2, "rad")}
"""Supports by a tape measure and by joint angles differ by less; of opposite signs, by half."""
SAMPLES = 50
"""Instants of a run at which its support is looked at."""


def check_angles(
    mapping: Path, files: MappedFiles, runs: Sequence[ImportedRun]
) -> list[ImportedRun]:
    """The runs, with notes on joint angles beyond the URDF's limits and on other supports.

    Args:
        mapping: the mapping file, whose trials the runs are, in its order.
        files: that it names.
        runs: as read.

    Raises:
        RecordingError: for joints that are missing or have no angles, and for angles in degrees.
        FieldError: for a support of the opposite sign than the joint angles give.
    """
    limits = read_outline(files.urdf).limits
    optional = optional_joints(files.robot)
    kinematics = _kinematics(files) if any(one.run.support for one in runs) else None
    checked = []
    for place, one in enumerate(runs):
        angles = _angles(one)
        for joint, (times, _) in angles.items():
            if not len(times) and joint not in optional:
                raise no_angles(one.source, joint, files.robot)
        notes = _beyond_limits(one.source, angles, limits)
        if kinematics is not None and one.run.support is not None and not notes:
            found = _support(one.source, kinematics, angles)
            field = f"trials[{place}].support"
            notes += _compare(mapping, field, one.source, one.run.support, found)
        checked.append(replace(one, notes=(*one.notes, *notes)))
    return checked


def optional_joints(robot: Path) -> list[str]:
    """Joints that a robot file lets be absent; FileError where it cannot be read."""
    fields = read_yaml(robot)
    return fields.texts("optional_joints") if "optional_joints" in fields else []


def no_angles(source: Path, joint: str, robot: Path, where: str = "") -> RecordingError:
    """The error to raise for a joint of which a recording holds no angle."""
    return RecordingError(
        source,
        f"holds no angle of joint '{joint}'; record it, or list it under 'optional_joints' of "
        f"{robot.name} if it stands still",
        field=where,
    )


def _kinematics(files: MappedFiles) -> Kinematics | None:
    """Of the robot in its shoes; None where its file is not ready, which its use will report."""
    with suppress(FileError):
        return Kinematics(load_robot(files.robot, load_shoe(files.shoe), urdf=files.urdf))
    return None


def _angles(run: ImportedRun) -> dict[str, tuple[Floats, Floats]]:
    """Times (k,) since 1970 [s] and angles (k,) [rad] by joint, of where it has some."""
    data = [one.data for one in run.messages if one.topic == schemas.JOINT_STATES]
    pieces: dict[str, list[Floats]] = {}
    for block in decode_columns(schemas.RUN_TOPICS[schemas.JOINT_STATES], data):
        times = block.stamp_ns / 1e9
        for name, position in zip(block.texts["name"], block.numbers["position"].T, strict=True):
            there = np.isfinite(position)
            pieces.setdefault(name, []).append(np.stack([times[there], position[there]]))
    angles = {}
    for name, found in pieces.items():
        times, positions = np.hstack(found)
        order = np.argsort(times, kind="stable")
        angles[name] = times[order], positions[order]
    return angles


def _beyond_limits(
    source: Path,
    angles: Mapping[str, tuple[Floats, Floats]],
    limits: Mapping[str, tuple[float, float]],
) -> list[str]:
    """A line on the joints beyond their limits, the first of them with its angle; or none."""
    found: dict[str, str] = {}
    for joint, (_, position) in angles.items():
        if joint not in limits or not len(position):
            continue
        excess = beyond_limits(joint, position, *limits[joint])
        if excess and in_degrees(position, *limits[joint]):
            raise RecordingError(
                source,
                f"{excess}, but within them in degrees; give the mapping "
                "'angle_unit: deg', or correct its zero",
            )
        if excess:
            found[joint] = excess
    if not found:
        return []
    first, *others = found
    more = f", and so are {', '.join(others)}" if others else ""
    return [f"{found[first]}{more}: check unit, sign and zero"]


def _support(
    source: Path, kinematics: Kinematics, angles: Mapping[str, tuple[Floats, Floats]]
) -> DoubleSupport:
    """Where the right sole is by forward kinematics."""
    robot = kinematics.robot
    known = {name: one for name, one in angles.items() if len(one[0]) and name in robot.joint_names}
    first = max((times[0] for times, _ in known.values()), default=0.0)
    last = min((times[-1] for times, _ in known.values()), default=0.0)
    instants = np.linspace(first, last, SAMPLES)
    positions = [np.interp(instants, *one) for one in known.values()]
    try:
        measured = robot.from_measured(list(known), np.reshape(positions, (-1, SAMPLES)).T)
    except JointsMissingError as error:
        raise RecordingError(source, str(error)) from error
    return kinematics.states(measured).support()


def _compare(
    mapping: Path, field: str, source: Path, given: DoubleSupport, found: DoubleSupport
) -> list[str]:
    """Numbers of a support that differ from those by the joint angles, a line each."""
    notes = []
    for name, (limit, unit) in APART.items():
        own, seen = getattr(given, name), getattr(found, name)
        apart = abs(math.remainder(own - seen, math.tau) if unit == "rad" else own - seen)
        opposite = abs(own + seen) < 0.25 * apart
        if apart <= (0.5 * limit if opposite else limit):
            continue
        difference = f"{name} is {own:.4g} {unit}, but {seen:.4g} {unit} by the joint angles"
        if opposite:
            raise FieldError(
                mapping,
                f"{difference} of {source.name}: the sign is opposite; correct it (right sole in "
                "the left one's frame: dx forward, dy to the left, dtheta counter-clockwise), or "
                "the signs of the joints",
                field=field,
            )
        notes.append(f"support: {difference}; correct it, or check the joints' zeros")
    return notes
