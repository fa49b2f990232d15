"""Joint angles of imported recordings, compared with limits, supports and soles that are level;
and stamps of receipt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, FileError
from shoecal_core.files import read_yaml
from shoecal_core.recording import schemas
from shoecal_core.recording.columns import Block, decode_columns
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.imports.foreign import ImportedRun
from shoecal_core.recording.imports.mapping import MappingHead
from shoecal_core.recording.imports.standing import (
    Feet,
    find_feet,
    find_feet_exchanged,
)
from shoecal_core.recording.info import HANGING
from shoecal_core.recording.joint_series import (
    JointSeries,
    Series,
    beyond_limits,
    from_pieces,
    in_degrees,
    with_numbers,
    without_zeros,
)
from shoecal_core.recording.packets import ANGLES_S, READINGS_S, find_packets
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import read_outline
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe

APART = {"dx": (0.05, "m"), "dy": (0.05, "m"), "dtheta": (0.2, "rad")}
"""Supports by a tape measure and by joint angles differ by less; of opposite signs, by half."""


def check_angles(head: MappingHead, runs: Sequence[ImportedRun]) -> list[ImportedRun]:
    """The runs, with notes on what is wrong with their joint angles: no numbers, jumps to zero,
    beyond the URDF's limits, soles that are not level, other supports.

    Args:
        head: of the mapping file, whose trials the runs are, in its order.
        runs: as read.

    Raises:
        RecordingError: for joints that are missing or have no angles, for angles in degrees,
            for angles and readings without a time in common, and for
            what is stamped packet by packet.
        FieldError: for a support of the opposite sign than the joint angles give.
    """
    limits = read_outline(head.urdf).limits
    optional = optional_joints(head.robot)
    standing = [_stands(one) for one in runs]
    shoe, kinematics = _shoe_and_kinematics(head) if any(standing) else (None, None)
    checked = []
    for place, (one, stands) in enumerate(zip(runs, standing, strict=True)):
        angles, lacking = with_numbers(_angles(one), optional)
        for joint, series in angles.items():
            if not len(series.time) and joint not in optional:
                raise no_angles(one.source, joint, head.robot)
        readings = _readings(one)
        _check_packets(one.source, angles, readings)
        _check_common_time(one.source, angles, readings)
        angles, jumping = without_zeros(angles)
        notes = _beyond_limits(one.source, angles, limits)
        if shoe is not None and kinematics is not None and stands:
            feet = _feet(one, kinematics, shoe, angles, readings)
            others = _exchanged(one, kinematics, shoe, angles, readings, feet)
            given = one.trial.support
            wrong = "" if feet is None else feet.wrong(stand=given is not None)
            if wrong:
                notes.append(wrong)
            elif feet is not None and given is not None and not notes:
                field = f"trials[{place}].support"
                notes += _compare(head.path, field, one.source, given, feet.support, others)
        checked.append(replace(one, notes=(*one.notes, *lacking, *jumping, *notes)))
    return checked


def _stands(one: ImportedRun) -> bool:
    """Whether both feet stand, as far as the trial says: it has a support, or nothing else."""
    poses = any(message.topic == schemas.BASE_POSE for message in one.messages)
    return one.trial.support is not None or not (poses or one.trial.motion == HANGING)


def optional_joints(robot: Path) -> list[str]:
    """Joints that a robot file lets be absent; FileError where it cannot be read."""
    fields = read_yaml(robot)
    return fields.texts("optional_joints") if "optional_joints" in fields else []


def no_angles(source: Path, joint: str, robot: Path, where: str = "") -> RecordingError:
    """The error to raise for a joint of which a recording holds no angle."""
    return RecordingError(
        source,
        f"holds no angle of joint '{joint}'; record it, or, if it stands still and is none of the "
        f"legs, list it under 'optional_joints' of {robot.name}",
        field=where,
    )


def _shoe_and_kinematics(head: MappingHead) -> tuple[Shoe | None, Kinematics | None]:
    """Of the robot in its shoes; None where its file is not ready, which its use will report."""
    with suppress(FileError):
        shoe = load_shoe(head.shoe)
        return shoe, Kinematics(load_robot(head.robot, shoe, urdf=head.urdf))
    return None, None


def _blocks(run: ImportedRun, topic: str) -> list[Block]:
    data = [one.data for one in run.messages if one.topic == topic]
    return decode_columns(schemas.RUN_TOPICS[topic], data)


def _angles(run: ImportedRun) -> dict[str, JointSeries]:
    """Of the joints, by stamps since 1970 [s]."""
    pieces: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
    for block in _blocks(run, schemas.JOINT_STATES):
        for name, position in zip(block.texts["name"], block.numbers["position"].T, strict=True):
            pieces.setdefault(name, []).append((block.stamp_ns / 1e9, position))
    return from_pieces(pieces)


def _beyond_limits(
    source: Path,
    angles: Series,
    limits: Mapping[str, tuple[float, float]],
) -> list[str]:
    """A line on the joints beyond their limits, the first of them with its angle; or none."""
    found: dict[str, str] = {}
    for joint, series in angles.items():
        position = series.angle
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


def _readings(run: ImportedRun) -> Series:
    """Of the cells and the six-axis sensors, by stamps since 1970 [s]."""
    pieces: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
    for block in _blocks(run, schemas.VOLTAGES):
        for name, values in zip(block.texts["cell"], block.numbers["voltage"].T, strict=False):
            pieces.setdefault(name, []).append((block.stamp_ns / 1e9, values))
    for foot, topic in zip(FEET, schemas.FORCE_TORQUE, strict=True):
        for block in _blocks(run, topic):
            force = block.numbers["wrench.force.z"][:, 0]
            pieces.setdefault(f"{foot}/fz", []).append((block.stamp_ns / 1e9, force))
    return from_pieces(pieces)


def _feet(
    run: ImportedRun, kinematics: Kinematics, shoe: Shoe, angles: Series, readings: Series
) -> Feet | None:
    """How they stand; None where joints are missing and the trial has no support.

    Raises:
        RecordingError: the trial has a support, and joints are missing.
    """
    try:
        return find_feet(kinematics, shoe, angles, readings)
    except JointsMissingError as error:
        if run.trial.support is None:
            return None
        raise RecordingError(run.source, str(error)) from error


def _check_common_time(source: Path, angles: Series, readings: Series) -> None:
    """Refuse angles and readings whose stamps do not meet."""
    spans = [
        (min(float(time[0]) for time in times), max(float(time[-1]) for time in times))
        for series in (angles, readings)
        if (times := [one.time for one in series.values() if len(one.time)])
    ]
    if len(spans) < 2:
        return
    (first, last), (other_first, other_last) = spans
    if first <= other_last and other_first <= last:
        return
    raise RecordingError(
        source,
        f"its joint angles are stamped {first:.3f} to {last:.3f} s, its readings "
        f"{other_first:.3f} to {other_last:.3f} s, none in common: stamp both by one clock, or "
        "list the topics of both under 'received' of the mapping, so that times of receipt count",
    )


def _exchanged(
    run: ImportedRun,
    kinematics: Kinematics,
    shoe: Shoe,
    angles: Series,
    readings: Series,
    feet: Feet | None,
) -> bool:
    """Whether the legs' angles under each other's names agree with the trial's support, though the
    feet stand still and level as recorded, too.
    """
    given = run.trial.support
    if feet is None or given is None or not _apart(given, feet.support):
        return False
    if feet.moves or feet.wrong(stand=True):
        return False
    other = find_feet_exchanged(kinematics, shoe, angles, readings)
    return other is not None and not _apart(given, other.support)


def _check_packets(source: Path, angles: Series, readings: Series) -> None:
    """Refuse angles or readings whose stamps are those of their receipt in packets."""
    for what, series, bearable in (
        ("joint angles", angles, ANGLES_S),
        ("readings", readings, READINGS_S),
    ):
        for name, one in series.items():
            if (packets := find_packets(one.time, bearable)) is not None:
                raise RecordingError(source, packets.describe(what), field=name)


def _apart(given: DoubleSupport, found: DoubleSupport) -> dict[str, bool]:
    """Numbers of a support that differ from those by the joint angles, and whether their signs are
    opposite.
    """
    names = {}
    for name, (limit, unit) in APART.items():
        own, seen = getattr(given, name), getattr(found, name)
        apart = abs(math.remainder(own - seen, math.tau) if unit == "rad" else own - seen)
        opposite = abs(own + seen) < 0.25 * apart
        if apart > (0.5 * limit if opposite else limit):
            names[name] = opposite
    return names


def _compare(
    mapping: Path,
    field: str,
    source: Path,
    given: DoubleSupport,
    found: DoubleSupport,
    exchanged: bool,
) -> list[str]:
    """Numbers of a support that differ from those by the joint angles, a line each.

    Args:
        mapping, field: where the support is given.
        source: of the joint angles.
        given, found: the support there and by the joint angles.
        exchanged: with the legs' angles at each other's place they would not differ.
    """
    notes = []
    legs = ", or exchange the left and the right leg's joints, which agree with it then"
    cause = legs if exchanged else ""
    for name, opposite in _apart(given, found).items():
        own, seen, unit = getattr(given, name), getattr(found, name), APART[name][1]
        difference = f"{name} is {own:.4g} {unit}, but {seen:.4g} {unit} by the joint angles"
        if opposite:
            raise FieldError(
                mapping,
                f"{difference} of {source.name}: the sign is opposite; correct it (right sole in "
                "the left one's frame: dx forward, dy to the left, dtheta counter-clockwise), or "
                f"the signs of the joints{cause}",
                field=field,
            )
        notes.append(f"support: {difference}; correct it, or check the joints' zeros{cause}")
    return notes
