"""Signals of a foreign recording, made into the runs of a session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import FieldError, FileTooLargeError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.container import MAX_RECORDS
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.imports.mapping import MappingHead, Trial
from shoecal_core.recording.run import UNIT_TOLERANCE
from shoecal_core.recording.session import Session
from shoecal_core.shoe.shoe import AXES, FEET, Shoe

Stamps = IntArray

LATEST_NS = 2**31 * messages.SECOND_NS
"""Stamps of ROS 2 end there."""


@dataclass(frozen=True)
class StampedMessage:
    """One message of a run: stamp [ns], topic, CDR bytes."""

    stamp_ns: int
    topic: str
    data: bytes


@dataclass(frozen=True)
class ImportedRun:
    """One recording, read and converted.

    Attributes:
        source: the file or folder it comes from.
        trial: of the mapping.
        messages: in any order.
        notes: what was changed or left out, a line each.
    """

    source: Path
    trial: Trial
    messages: list[StampedMessage]
    notes: tuple[str, ...]


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


def write_session(out: Path, head: MappingHead, runs: Sequence[ImportedRun]) -> Session:
    """Make a session of imported recordings, with the files that their mapping names.

    Raises:
        FileTooLargeError: a recording is longer than a run may be; nothing is made then.
        FileError: as `Session.create` and `RunWriter`.
    """
    for one in runs:
        check_length(one.source, len(one.messages))
    session = Session.create(out, head.robot, head.urdf, head.shoe)
    for one in runs:
        trial = one.trial
        with session.new_run(
            trial.motion, trial.support, hint=trial.hint, live=False, notes=one.notes
        ) as writer:
            for message in sorted(one.messages, key=attrgetter("stamp_ns")):
                writer.write(message.topic, message.data, message.stamp_ns)
    return session


def joint_states(
    stamps: Stamps, names: Sequence[str], position: FloatArray, effort: FloatArray | None = None
) -> list[StampedMessage]:
    """/joint_states: position (T, m) [rad] and effort (T, m) [N m] at stamps (T,) [ns]."""
    count = len(names)
    return _series(
        schemas.JOINT_STATES,
        stamps,
        position if effort is None else np.hstack([position, effort]),
        lambda stamp, row: messages.joint_state(
            stamp, names, row[:count], None if effort is None else row[count:]
        ),
    )


def wrenches(foot: str, stamps: Stamps, frame: str, values: FloatArray) -> list[StampedMessage]:
    """/ft/left or /ft/right: forces [N], then torques [N m] (T, 6) at stamps (T,) [ns]."""
    return _series(
        schemas.FORCE_TORQUE[FEET.index(foot)],
        stamps,
        values,
        lambda stamp, row: messages.wrench(stamp, frame, row[:3], row[3:]),
    )


def whole_poses(source: Path, name: str, values: FloatArray, notes: list[str]) -> BoolArray:
    """Which poses (T, 7), as `base_poses` takes them, count: numbers, quaternions of unit length.

    Others are noted.

    Raises:
        RecordingError: where none counts.
    """
    length = np.linalg.norm(values[:, 3:], axis=1)
    good: BoolArray = np.isfinite(values).all(axis=1) & (np.abs(length - 1.0) < UNIT_TOLERANCE)
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


def base_poses(stamps: Stamps, frame: str, values: FloatArray) -> list[StampedMessage]:
    """/base_pose: positions [m], then quaternions x y z w in `frame` (T, 7) at stamps (T,) [ns]."""
    return _series(
        schemas.BASE_POSE,
        stamps,
        values,
        lambda stamp, row: messages.pose(stamp, frame, row[:3], row[3:]),
    )


def imu(stamps: Stamps, frame: str, values: FloatArray) -> list[StampedMessage]:
    """/imu: rates [rad/s], then accelerations [m/s^2] (T, 6) in `frame` at stamps (T,) [ns].

    Orientations x y z w may follow: (T, 10).
    """
    oriented = values.shape[1] > 6
    return _series(
        schemas.IMU,
        stamps,
        values,
        lambda stamp, row: messages.imu(
            stamp, frame, row[6:] if oriented else None, row[:3], row[3:6]
        ),
    )


def voltages(
    stamps: Stamps, cells: Sequence[str], values: FloatArray, frame: str = ""
) -> list[StampedMessage]:
    """/shoe/voltages: readings (T, k) of k cells at stamps (T,) [ns]; NaN is status NO_DATA."""
    status = np.where(np.isfinite(values), schemas.GOOD, schemas.NO_DATA)
    data = [
        messages.shoe_voltages(stamp, sequence, cells, row, status[sequence], frame_id=frame)
        for sequence, (stamp, row) in enumerate(zip(stamps.tolist(), values, strict=True))
    ]
    return _stamped(schemas.VOLTAGES, stamps, data)


def _series(
    topic: str, stamps: Stamps, values: FloatArray, one: Callable[[int, FloatArray], bytes]
) -> list[StampedMessage]:
    """Messages of stamps (T,) [ns] and numbers (T, k), by what makes one of them."""
    return _stamped(topic, stamps, messages.series(one, stamps, values))


def _stamped(topic: str, stamps: Stamps, data: Sequence[bytes]) -> list[StampedMessage]:
    return [
        StampedMessage(stamp, topic, one) for stamp, one in zip(stamps.tolist(), data, strict=True)
    ]
