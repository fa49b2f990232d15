"""Signals of a foreign recording, made into the runs of a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import FieldError, FileTooLargeError
from shoecal_core.files import Fields
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.container import MAX_RECORDS
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.info import HANGING
from shoecal_core.recording.listing import HINTS
from shoecal_core.recording.messages import series
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport, read_support
from shoecal_core.shoe.shoe import AXES, FEET, Shoe

Stamps = IntArray

UNIT_TOLERANCE = 0.1
"""Lengths of quaternions that count differ from one by less."""
LATEST_NS = 2**31 * messages.SECOND_NS
"""Stamps of ROS 2 end there."""


@dataclass(frozen=True)
class StampedMessage:
    """One message of a run: stamp [ns], topic, CDR bytes."""

    stamp_ns: int
    topic: str
    data: bytes


@dataclass(frozen=True)
class RunToImport:
    """How one imported recording is listed in the session.

    Attributes:
        motion: its name.
        support: pose of the right sole in the left; None where there is none, as in walking.
        hint: `train`, `test` or empty.
    """

    motion: str
    support: DoubleSupport | None
    hint: str


RUN_KEYS = ("motion", "support", "set")
"""Fields of a mapping's trial that `read_run_to_import` reads."""
SPAN_KEYS = ("from_s", "to_s")
"""Fields of a mapping's trial that `read_span` reads."""
ANGLE_UNIT = "angle_unit"
_ANGLE_UNITS = {"rad": 1.0, "deg": float(np.pi / 180.0)}


def read_angle_unit(fields: Fields) -> float:
    """What angles of the recordings take to be rad: `angle_unit` of a mapping, `rad` or `deg`."""
    return _ANGLE_UNITS[fields.choice(ANGLE_UNIT, _ANGLE_UNITS)] if ANGLE_UNIT in fields else 1.0


def read_span(fields: Fields) -> tuple[float | None, float | None]:
    """The fields SPAN_KEYS of one trial [s]; None: from the start, to the end."""
    from_s = fields.number("from_s", minimum=0.0) if "from_s" in fields else None
    to_s = fields.number("to_s", above=from_s or 0.0) if "to_s" in fields else None
    return from_s, to_s


def read_run_to_import(fields: Fields) -> RunToImport:
    """The fields RUN_KEYS of one trial in a mapping file; FileError where one is wrong."""
    motion, support = fields.text("motion"), read_support(fields)
    if motion == HANGING and support is not None:
        raise fields.error("support", "a robot that hangs stands nowhere; leave it out")
    return RunToImport(
        motion=motion,
        support=support,
        hint=fields.choice("set", dict.fromkeys(HINTS)) if "set" in fields else "",
    )


@dataclass(frozen=True)
class ImportedRun:
    """One recording, read and converted.

    Attributes:
        source: the file or folder it comes from.
        run: how it is listed.
        messages: in any order.
        notes: what was changed or left out, a line each.
    """

    source: Path
    run: RunToImport
    messages: list[StampedMessage]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class MappedFiles:
    """Robot file, URDF and shoe file that a mapping names."""

    robot: Path
    urdf: Path
    shoe: Path


def mapped_files(fields: Fields, folder: Path) -> MappedFiles:
    """The fields `robot`, `urdf` and `shoe` of a mapping file.

    Args:
        fields: of the mapping.
        folder: of the recordings; a file is looked for next to the mapping first, then here.

    Raises:
        FieldError: for one that is in neither place.
    """
    found = []
    for key in ("robot", "urdf", "shoe"):
        name = fields.text(key)
        places = [place / name for place in (fields.path.parent, folder)]
        if not any(place.is_file() for place in places):
            raise fields.error(key, f"'{name}' is neither next to this file nor in {folder}")
        found.append(next(place for place in places if place.is_file()))
    return MappedFiles(*found)


def check_six_axis(path: Path, field: str, shoe: Shoe, foot: str) -> None:
    """Refuse wrenches of a foot that has no six-axis sensor in the shoe file.

    Raises:
        FieldError: naming the mapping file and its field.
    """
    if not any(f"{foot}/{axis}" in shoe.names for axis in AXES):
        problem = f"'{shoe.name}' has no six-axis sensor on the {foot} foot; correct the shoe file"
        raise FieldError(path, problem, field=field)


def check_length(source: Path, count: int) -> None:
    """Refuse more messages than a run may hold.

    Raises:
        FileTooLargeError: naming the file that they come from.
    """
    if count > MAX_RECORDS:
        raise FileTooLargeError(
            source,
            f"holds over {MAX_RECORDS} messages, more than one run may; split it into several "
            "trials by 'from_s' and 'to_s'",
        )


def write_session(out: Path, files: MappedFiles, runs: Sequence[ImportedRun]) -> Session:
    """Make a session of imported recordings.

    Raises:
        FileTooLargeError: a recording is longer than a run may be; nothing is made then.
        FileError: as `Session.create` and `RunWriter`.
    """
    for one in runs:
        check_length(one.source, len(one.messages))
    session = Session.create(out, files.robot, files.urdf, files.shoe)
    for one in runs:
        run = one.run
        with session.new_run(
            run.motion, run.support, hint=run.hint, live=False, notes=one.notes
        ) as writer:
            for message in sorted(one.messages, key=attrgetter("stamp_ns")):
                writer.write(message.topic, message.data, message.stamp_ns)
    return session


def joint_states(
    stamps: Stamps, names: Sequence[str], position: FloatArray, effort: FloatArray | None = None
) -> list[StampedMessage]:
    """/joint_states: position (T, m) [rad] and effort (T, m) [N m] at stamps (T,) [ns]."""
    count = len(names)

    def one(stamp: int, values: FloatArray) -> bytes:
        """Positions, then efforts if any: (m,) or (2m,)."""
        return messages.joint_state(
            stamp, names, values[:count], None if effort is None else values[count:]
        )

    values = position if effort is None else np.hstack([position, effort])
    return _stamped(schemas.JOINT_STATES, stamps, series(one, stamps, values))


def wrenches(
    foot: str, stamps: Stamps, frame: str, force: FloatArray, torque: FloatArray
) -> list[StampedMessage]:
    """/ft/left or /ft/right: force (T, 3) [N], torque (T, 3) [N m] at stamps (T,) [ns]."""
    topic = schemas.FORCE_TORQUE[FEET.index(foot)]

    def one(stamp: int, values: FloatArray) -> bytes:
        """Force, then torque: (6,)."""
        return messages.wrench(stamp, frame, values[:3], values[3:])

    return _stamped(topic, stamps, series(one, stamps, np.hstack([force, torque])))


def whole_poses(
    source: Path, name: str, position: FloatArray, quaternion: FloatArray, notes: list[str]
) -> BoolArray:
    """Which poses (T,) count: numbers, and quaternions x y z w (T, 4) of unit length.

    Others are noted.

    Raises:
        RecordingError: where none counts.
    """
    length = np.linalg.norm(quaternion, axis=1)
    good: BoolArray = np.isfinite(position).all(axis=1) & (np.abs(length - 1.0) < UNIT_TOLERANCE)
    if not good.any():
        raise RecordingError(
            source,
            "none of its poses has a position and a unit quaternion x y z w; correct its sender, "
            "or take the base pose out of the mapping",
            field=name,
        )
    if not good.all():
        notes.append(f"{name}: {np.count_nonzero(~good)} of {len(good)} are no poses, left out")
    return good


def base_poses(
    stamps: Stamps, frame: str, position: FloatArray, quaternion: FloatArray
) -> list[StampedMessage]:
    """/base_pose: position (T, 3) [m], quaternion (T, 4) x y z w in `frame`."""

    def one(stamp: int, values: FloatArray) -> bytes:
        """Position, then quaternion: (7,)."""
        return messages.pose(stamp, frame, values[:3], values[3:])

    return _stamped(
        schemas.BASE_POSE, stamps, series(one, stamps, np.hstack([position, quaternion]))
    )


def imu(
    stamps: Stamps,
    frame: str,
    quaternion: FloatArray | None,
    rate: FloatArray,
    acceleration: FloatArray,
) -> list[StampedMessage]:
    """/imu: orientation (T, 4) x y z w or None, rate (T, 3) [rad/s], (T, 3) [m/s^2] in `frame`."""

    def one(stamp: int, values: FloatArray) -> bytes:
        """Rate, acceleration, then the quaternion if any: (6,) or (10,)."""
        orientation = None if quaternion is None else values[6:]
        return messages.imu(stamp, frame, orientation, values[:3], values[3:6])

    values = [rate, acceleration] + ([] if quaternion is None else [quaternion])
    return _stamped(schemas.IMU, stamps, series(one, stamps, np.hstack(values)))


def voltages(stamps: Stamps, cells: Sequence[str], values: FloatArray) -> list[StampedMessage]:
    """/shoe/voltages: readings (T, k) of k cells at stamps (T,) [ns]; NaN is status NO_DATA."""
    status = np.where(np.isfinite(values), schemas.GOOD, schemas.NO_DATA)
    data = [
        messages.shoe_voltages(stamp, sequence, cells, row, status[sequence])
        for sequence, (stamp, row) in enumerate(zip(stamps.tolist(), values, strict=True))
    ]
    return _stamped(schemas.VOLTAGES, stamps, data)


def _stamped(topic: str, stamps: Stamps, data: Sequence[bytes]) -> list[StampedMessage]:
    return [
        StampedMessage(stamp, topic, one) for stamp, one in zip(stamps.tolist(), data, strict=True)
    ]
