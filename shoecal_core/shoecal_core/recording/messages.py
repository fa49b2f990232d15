"""Building the recorded messages as CDR bytes, without ROS."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rosbags.typesys.stores import ros2_jazzy as ros

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording.schemas import SHOE_VOLTAGES_TYPE, typestore

SECOND_NS = 1_000_000_000
_UNKNOWN_COVARIANCE = np.zeros(9)
_SECONDS, _NANOSECONDS = 0x12345678, 0x1234567
"""Of a stamp that marks its place in a message."""


def joint_state(
    stamp_ns: int, names: Sequence[str], position: ArrayLike, effort: ArrayLike | None = None
) -> bytes:
    """sensor_msgs/JointState: angles (m,) [rad], effort (m,) [N m] where known."""
    message = ros.sensor_msgs__msg__JointState(
        header=_header(stamp_ns, ""),
        name=list(names),
        position=_vector("position", position, len(names)),
        velocity=np.empty(0),
        effort=np.empty(0) if effort is None else _vector("effort", effort, len(names)),
    )
    return _serialise(message)


def shoe_voltages(
    stamp_ns: int,
    sequence: int,
    cells: Sequence[str],
    voltage: ArrayLike,
    status: ArrayLike,
    *,
    temperature: float = np.nan,
    frame_id: str = "",
) -> bytes:
    """shoecal_msgs/ShoeVoltages: readings (k,) of k cells [V], their status (k,)."""
    message = typestore().types[SHOE_VOLTAGES_TYPE](
        header=_header(stamp_ns, frame_id),
        sequence=sequence % 2**32,
        cell=list(cells),
        voltage=_vector("voltage", voltage, len(cells)),
        status=_vector("status", status, len(cells)).astype(np.uint8),
        temperature=float(temperature),
    )
    return _serialise(message)


def wrench(stamp_ns: int, frame_id: str, force: Iterable[float], torque: Iterable[float]) -> bytes:
    """geometry_msgs/WrenchStamped: force (3,) [N] and torque (3,) [N m] in `frame_id`."""
    return _serialise(
        ros.geometry_msgs__msg__WrenchStamped(
            header=_header(stamp_ns, frame_id),
            wrench=ros.geometry_msgs__msg__Wrench(
                force=_vector3("force", force), torque=_vector3("torque", torque)
            ),
        )
    )


def point(stamp_ns: int, frame_id: str, position: Iterable[float]) -> bytes:
    """geometry_msgs/PointStamped: position (3,) [m] in `frame_id`."""
    return _serialise(
        ros.geometry_msgs__msg__PointStamped(
            header=_header(stamp_ns, frame_id),
            point=ros.geometry_msgs__msg__Point(*_floats("position", position, 3)),
        )
    )


def pose(
    stamp_ns: int, frame_id: str, position: Iterable[float], quaternion: Iterable[float]
) -> bytes:
    """geometry_msgs/PoseStamped: position (3,) [m], quaternion (4,) x y z w, in `frame_id`."""
    return _serialise(
        ros.geometry_msgs__msg__PoseStamped(
            header=_header(stamp_ns, frame_id),
            pose=ros.geometry_msgs__msg__Pose(
                position=ros.geometry_msgs__msg__Point(*_floats("position", position, 3)),
                orientation=_quaternion(quaternion),
            ),
        )
    )


def imu(
    stamp_ns: int,
    frame_id: str,
    quaternion: Iterable[float] | None,
    angular_velocity: Iterable[float],
    linear_acceleration: Iterable[float],
) -> bytes:
    """sensor_msgs/Imu: orientation (4,) x y z w or None, rates (3,) [rad/s], (3,) [m/s^2]."""
    # By the message's definition -1 as first element says that there is no orientation.
    covariance = np.array([-1.0, *np.zeros(8)]) if quaternion is None else _UNKNOWN_COVARIANCE
    return _serialise(
        ros.sensor_msgs__msg__Imu(
            header=_header(stamp_ns, frame_id),
            orientation=_quaternion([0.0, 0.0, 0.0, 1.0] if quaternion is None else quaternion),
            orientation_covariance=covariance,
            angular_velocity=_vector3("angular_velocity", angular_velocity),
            angular_velocity_covariance=_UNKNOWN_COVARIANCE,
            linear_acceleration=_vector3("linear_acceleration", linear_acceleration),
            linear_acceleration_covariance=_UNKNOWN_COVARIANCE,
        )
    )


def temperature(stamp_ns: int, frame_id: str, value: float) -> bytes:
    """sensor_msgs/Temperature [degC]; for a motor `frame_id` is the joint's name."""
    return _serialise(
        ros.sensor_msgs__msg__Temperature(
            header=_header(stamp_ns, frame_id), temperature=float(value), variance=0.0
        )
    )


def joint_trajectory(
    stamp_ns: int, names: Sequence[str], time_from_start: ArrayLike, position: ArrayLike
) -> bytes:
    """trajectory_msgs/JointTrajectory: times (K,) [s], angles (K, m) [rad].

    Raises:
        ShapeError: for angles of another shape.
    """
    times = np.asarray(time_from_start, dtype=np.float64)
    angles = np.asarray(position, dtype=np.float64)
    if times.ndim != 1 or angles.shape != (len(times), len(names)):
        raise ShapeError("position", f"({times.size}, {len(names)})", angles.shape)
    empty = np.empty(0)
    points = [
        ros.trajectory_msgs__msg__JointTrajectoryPoint(
            positions=row,
            velocities=empty,
            accelerations=empty,
            effort=empty,
            time_from_start=ros.builtin_interfaces__msg__Duration(
                *divmod(round(time * SECOND_NS), SECOND_NS)
            ),
        )
        for time, row in zip(times.tolist(), np.ascontiguousarray(angles), strict=True)
    ]
    return _serialise(
        ros.trajectory_msgs__msg__JointTrajectory(
            header=_header(stamp_ns, ""), joint_names=list(names), points=points
        )
    )


def series(
    one: Callable[[int, FloatArray], bytes],
    stamps: IntArray,
    values: FloatArray,
) -> list[bytes]:
    """Messages that differ in their stamp and in numbers alone.

    One message is made with numbers that occur nowhere else; where they stand in its bytes, those
    of all others stand too.

    Args:
        one: makes a message (CDR, little endian) of a stamp [ns] and numbers (k,), each of which
            it writes once, as a float64.
        stamps: (T,) [ns].
        values: (T, k).

    Raises:
        ShapeError: when there are more or fewer rows than stamps.
        ShoecalError: for a stamp that cannot be recorded, or a `one` that keeps to something else.
    """
    if values.ndim != 2 or len(values) != len(stamps):
        raise ShapeError("values", f"({len(stamps)}, k)", values.shape)
    if not len(stamps):
        return []
    if stamps.min() < 0 or stamps.max() >= 2**31 * SECOND_NS:
        raise ShoecalError(f"stamps {stamps.min()} to {stamps.max()} ns: must be 0 to 2^31 s")
    marks: FloatArray = np.pi * 1e7 + np.arange(values.shape[1], dtype=np.float64)
    template = one(_SECONDS * SECOND_NS + _NANOSECONDS, marks)
    rows = np.tile(np.frombuffer(template, dtype=np.uint8), (len(stamps), 1))
    seconds, nanoseconds = np.divmod(stamps, SECOND_NS)
    place = _place(template, struct.pack("<iI", _SECONDS, _NANOSECONDS))
    rows[:, place : place + 8] = _bytes(np.stack((seconds, nanoseconds), axis=1).astype("<u4"))
    for mark, column in zip(marks.tolist(), values.T, strict=True):
        place = _place(template, struct.pack("<d", mark))
        rows[:, place : place + 8] = _bytes(column.astype("<f8"))
    return [row.tobytes() for row in rows]


class _Message(Protocol):
    __msgtype__: ClassVar[str]


def _serialise(message: _Message) -> bytes:
    return bytes(typestore().serialize_cdr(message, message.__msgtype__, little_endian=True))


def _header(stamp_ns: int, frame_id: str) -> ros.std_msgs__msg__Header:
    sec, nanosec = divmod(int(stamp_ns), SECOND_NS)
    if not 0 <= sec < 2**31:
        raise ShoecalError(f"stamp {stamp_ns} ns cannot be recorded: must be 0 to 2^31 s")
    stamp = ros.builtin_interfaces__msg__Time(sec=sec, nanosec=nanosec)
    return ros.std_msgs__msg__Header(stamp=stamp, frame_id=frame_id)


def _vector(name: str, values: ArrayLike, length: int) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    if array.shape != (length,):
        raise ShapeError(name, f"({length},)", array.shape)
    return array


def _floats(name: str, values: Iterable[float], length: int) -> list[float]:
    floats = [float(value) for value in values]
    if len(floats) != length:
        raise ShapeError(name, f"({length},)", (len(floats),))
    return floats


def _vector3(name: str, values: Iterable[float]) -> ros.geometry_msgs__msg__Vector3:
    return ros.geometry_msgs__msg__Vector3(*_floats(name, values, 3))


def _quaternion(values: Iterable[float]) -> ros.geometry_msgs__msg__Quaternion:
    return ros.geometry_msgs__msg__Quaternion(*_floats("quaternion", values, 4))


def _bytes(values: NDArray[np.generic]) -> NDArray[np.uint8]:
    """(T, 8) bytes of eight-byte rows."""
    return np.ascontiguousarray(values).view(np.uint8).reshape(len(values), 8)


def _place(template: bytes, mark: bytes) -> int:
    """Where the one occurrence of a mark begins."""
    if template.count(mark) != 1:
        raise ShoecalError("a message of a series must hold its stamp and each number once")
    return template.index(mark)
