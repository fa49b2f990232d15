"""From a run file to a Run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys.stores.ros2_jazzy import (
    trajectory_msgs__msg__JointTrajectory as JointTrajectory,
)

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording import schemas
from shoecal_core.recording.columns import Block
from shoecal_core.recording.container import read_container
from shoecal_core.recording.join import Piece, two_orders, two_orders_text
from shoecal_core.recording.joint_series import (
    JointSeries,
    jumps_to_zero,
    lacking_notes,
    zero_notes,
)
from shoecal_core.recording.readings import make_readings, read_readings
from shoecal_core.recording.run import (
    UNIT_TOLERANCE,
    CommandedTrajectory,
    ImuSamples,
    JointSamples,
    PoseSamples,
    Run,
    TemperatureSamples,
)
from shoecal_core.recording.source import RecordedSource
from shoecal_core.shoe.shoe import Shoe

_QUATERNION = tuple(f"orientation.{axis}" for axis in "xyzw")


def read_run(path: Path, shoe: Shoe) -> Run:
    """Read one run, whole and checked.

    Args:
        path: a finished run file.
        shoe: whose channels the readings are of.

    Raises:
        DamagedError: for a file that is cut, unfinished or altered.
        RecordingError: for one that is no run, or whose messages contradict each other or
            the shoe.
        VersionError: for one written by a newer shoecal.
    """
    source = RecordedSource(read_container(Path(path), schemas.RUN_TOPICS), schemas.RUN_TOPICS)
    joint_stamps, names, joints = _joints(source)
    reading_stamps, readings = read_readings(source, shoe)
    start = int(min(joint_stamps[0], reading_stamps[0]))
    effort = joints["effort"]
    return Run(
        path=source.contents.path,
        info=source.contents.info,
        start_ns=start,
        joints=JointSamples(
            time=seconds(joint_stamps, start),
            names=names,
            position=joints["position"],
            effort=None if np.isnan(effort).all() else effort,
        ),
        readings=make_readings(source, shoe, seconds(reading_stamps, start), readings),
        commanded=_commanded(source, start),
        base_pose=_base_pose(source, start),
        imu=_imu(source, start),
        shoe_temperature=_shoe_temperature(source, start),
        notes=tuple(dict.fromkeys((*source.contents.info.notes, *source.notes))),
    )


def seconds(stamp_ns: IntArray, start_ns: int) -> FloatArray:
    """Stamps (T,) as times since the start [s]."""
    return (stamp_ns - start_ns) / 1e9


def _joints(
    source: RecordedSource,
) -> tuple[IntArray, tuple[str, ...], dict[str, FloatArray]]:
    topic = schemas.JOINT_STATES
    blocks = source.blocks(topic)
    names = tuple(dict.fromkeys(name for block in blocks for name in block.texts["name"]))
    if not names:
        raise source.error("", f"holds no joint angles ({topic}); record them")
    if (
        twice := two_orders([(block.texts["name"], block.stamp_ns) for block in blocks])
    ) is not None:
        raise source.error(topic, two_orders_text(*twice))
    pieces = []
    lacking, naming = np.zeros(len(names), dtype=int), np.zeros(len(names), dtype=int)
    for block in blocks:
        columns = source.columns(topic, block.texts["name"], names)
        values = {"position": block.numbers["position"]}
        if block.numbers["effort"].shape[1]:
            values["effort"] = block.numbers["effort"]
        for quantity, numbers in values.items():
            if numbers.shape[1] != len(columns):
                raise source.error(
                    topic,
                    f"has {numbers.shape[1]} values of '{quantity}' for {len(columns)} joints; "
                    "correct its sender",
                )
            numbers[~np.isfinite(numbers)] = np.nan
        lacking[columns] += np.isnan(values["position"]).sum(axis=0)
        naming[columns] += len(block.index)
        pieces.append(Piece(block.stamp_ns, columns, values))
    stamps, joined = source.join(topic, pieces, names, ("position", "effort"))
    never = np.isnan(joined["position"]).all(axis=0)
    source.notes += [f"joint '{name}' was never recorded" for name in np.array(names)[never]]
    source.notes += lacking_notes(
        {names[at]: (int(lacking[at]), int(naming[at])) for at in np.flatnonzero(~never)}
    )
    source.notes += _leave_out_zeros(stamps, names, joined["position"])
    return stamps, names, joined


def _leave_out_zeros(stamps: IntArray, names: tuple[str, ...], position: FloatArray) -> list[str]:
    """Make jumps to zero of angles (T, m) NaN, and note them."""
    known = np.isfinite(position)
    series = {
        name: JointSeries(stamps[there] / 1e9, angles[there])
        for name, there, angles in zip(names, known.T, position.T, strict=True)
    }
    zeros = jumps_to_zero(series)
    for column, name in enumerate(names):
        position[np.flatnonzero(known[:, column])[zeros[name]], column] = np.nan
    return zero_notes(series, zeros)


def _commanded(source: RecordedSource, start: int) -> tuple[CommandedTrajectory, ...]:
    topic = schemas.JOINT_TRAJECTORY
    messages = source.contents.messages.get(topic, [])
    commanded = []
    for data, log_time in zip(messages, source.contents.log_time_ns.get(topic, []), strict=True):
        try:
            message = schemas.typestore().deserialize_cdr(data, schemas.RUN_TOPICS[topic])
        except SerdeError as error:
            raise source.error(topic, f"{error}; correct its sender") from error
        assert isinstance(message, JointTrajectory)
        try:
            commanded.append(_trajectory(message, log_time, start))
        except (ShoecalError, ValueError) as error:
            source.notes.append(f"{topic}: one trajectory left out ({error})")
    return tuple(commanded)


def _trajectory(message: JointTrajectory, log_time: int, start: int) -> CommandedTrajectory:
    stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
    offsets = [point.time_from_start for point in message.points]
    moving = all(len(point.velocities) == len(message.joint_names) for point in message.points)
    return CommandedTrajectory(
        # By the message's convention a stamp of zero means: start when it arrives.
        start=((stamp or log_time) - start) / 1e9,
        names=tuple(message.joint_names),
        time=np.array([offset.sec + offset.nanosec / 1e9 for offset in offsets]),
        position=np.array([point.positions for point in message.points]),
        velocity=np.array([point.velocities for point in message.points]) if moving else None,
    )


def _base_pose(source: RecordedSource, start: int) -> PoseSamples | None:
    block = source.single(schemas.BASE_POSE)
    if block is None:
        return None
    position = block.group(*(f"pose.position.{axis}" for axis in "xyz"))
    quaternion = block.group(*(f"pose.{name}" for name in _QUATERNION))
    unit = np.abs(np.linalg.norm(quaternion, axis=1) - 1.0) < UNIT_TOLERANCE
    good = unit & np.isfinite(position).all(axis=1)
    if not good.all():
        source.notes.append(f"{schemas.BASE_POSE}: {int(np.sum(~good))} are no poses, left out")
    if not good.any():
        return None
    return PoseSamples(
        time=seconds(block.stamp_ns[good], start),
        position=position[good],
        quaternion=quaternion[good] / np.linalg.norm(quaternion[good], axis=1, keepdims=True),
    )


def _imu(source: RecordedSource, start: int) -> ImuSamples | None:
    block = source.single(schemas.IMU)
    if block is None:
        return None
    # By the message's definition -1 as first element says that there is no orientation.
    oriented = block.numbers["orientation_covariance"][:, 0] != -1.0
    quaternion = block.group(*_QUATERNION)
    length = np.linalg.norm(quaternion, axis=1, keepdims=True)
    unit = np.abs(length[:, 0] - 1.0) < UNIT_TOLERANCE
    if wrong := int(np.sum(oriented & ~unit)):
        source.notes.append(
            f"{schemas.IMU}: {wrong} of {len(unit)} orientations are no unit quaternions; taken as "
            "not there"
        )
    return ImuSamples(
        time=seconds(block.stamp_ns, start),
        frame=block.frame_id,
        quaternion=np.where(
            (oriented & unit)[:, None], quaternion / np.fmax(length, UNIT_TOLERANCE), np.nan
        ),
        angular_velocity=block.group(*(f"angular_velocity.{axis}" for axis in "xyz")),
        linear_acceleration=block.group(*(f"linear_acceleration.{axis}" for axis in "xyz")),
    )


def _shoe_temperature(source: RecordedSource, start: int) -> TemperatureSamples | None:
    block = source.single(schemas.SHOE_TEMPERATURE)
    return None if block is None else _temperature(block, start)


def _temperature(block: Block, start: int) -> TemperatureSamples:
    return TemperatureSamples(seconds(block.stamp_ns, start), block.numbers["temperature"][:, 0])
