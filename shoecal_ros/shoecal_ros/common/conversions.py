"""Messages to values of the core and back; the only place that knows both."""

from __future__ import annotations

import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import PointStamped, WrenchStamped
from sensor_msgs.msg import JointState
from shoecal_msgs import msg as shoecal_msg
from shoecal_msgs.msg import ShoeCalibration, ShoeVoltages
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg
from trajectory_msgs.msg import JointTrajectoryPoint

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.shoe.correction import POLYNOMIAL, CopCorrection
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_ros.common.names import short_name
from shoecal_ros.common.origin import EPOCH_NS, Origin
from shoecal_ros.common.voltage_frame import VoltageFrame

SECOND_NS = 1_000_000_000
CALIBRATION_FORMAT = 1
"""Version of the layout of ShoeCalibration."""

BASE_LINK = "base_link"
SOLES = ("l_sole", "r_sole")
"""Frames of the left and of the right sole."""


class MessageError(ShoecalError):
    """A message that contradicts itself."""


@dataclass(frozen=True)
class JointSample:
    """Joint angles at one instant.

    Attributes:
        stamp_ns: time of sampling [ns].
        names: k joints.
        position: (k,) [rad]; NaN where a joint reports none.
        effort: (k,) [N m], None where the robot reports none.
    """

    stamp_ns: int
    names: tuple[str, ...]
    position: FloatArray
    effort: FloatArray | None = None


# Time


def time_to_ros(stamp_ns: int) -> Time:
    """Time of nanoseconds since the epoch."""
    sec, nanosec = divmod(stamp_ns, SECOND_NS)
    return Time(sec=sec, nanosec=nanosec)


def time_from_ros(time: Time | Duration) -> int:
    """Nanoseconds of a time or a duration."""
    return int(time.sec) * SECOND_NS + int(time.nanosec)


def duration_to_ros(seconds: float) -> Duration:
    """Duration of seconds."""
    sec, nanosec = divmod(round(seconds * SECOND_NS), SECOND_NS)
    return Duration(sec=sec, nanosec=nanosec)


def header_to_ros(stamp_ns: int, frame_id: str = "") -> Header:
    """Header of a stamp [ns] and a frame."""
    return Header(stamp=time_to_ros(stamp_ns), frame_id=frame_id)


# Measurements


def joints_to_ros(sample: JointSample) -> JointState:
    """Joint angles as a message."""
    message = JointState()
    message.header = header_to_ros(sample.stamp_ns)
    message.name = list(sample.names)
    message.position = _doubles(sample.position)
    if sample.effort is not None:
        message.effort = _doubles(sample.effort)
    return message


def voltages_to_ros(frame: VoltageFrame) -> ShoeVoltages:
    """A device frame as a message."""
    message = ShoeVoltages()
    message.header = header_to_ros(frame.stamp_ns, frame.source)
    message.sequence = frame.sequence
    message.cell = list(frame.cells)
    message.voltage = _doubles(frame.voltage)
    message.status = array.array("B", frame.status.tobytes())
    message.temperature = frame.temperature
    return message


def voltages_from_ros(message: ShoeVoltages) -> VoltageFrame:
    """A device frame of a message.

    Raises:
        MessageError: when cells, voltages and statuses do not match.
    """
    cells = tuple(message.cell)
    voltage = np.array(message.voltage)
    status = np.array(message.status, dtype=np.uint8)
    if not len(cells) == len(voltage) == len(status):
        raise MessageError(
            f"shoe/voltages: {len(voltage)} voltages and {len(status)} statuses for "
            f"{len(cells)} cells; correct its sender"
        )
    return VoltageFrame(
        time_from_ros(message.header.stamp),
        message.header.frame_id,
        message.sequence,
        cells,
        voltage,
        status,
        message.temperature,
    )


# Double supports and motions


def support_to_ros(support: DoubleSupport) -> shoecal_msg.DoubleSupport:
    """A double support as a message."""
    return shoecal_msg.DoubleSupport(dx=support.dx, dy=support.dy, dtheta=support.dtheta)


def support_from_ros(message: shoecal_msg.DoubleSupport) -> DoubleSupport:
    """A double support of a message; ShoecalError where it holds no finite numbers."""
    return DoubleSupport(message.dx, message.dy, message.dtheta)


def trajectory_to_ros(trajectory: JointTrajectory, stamp_ns: int = 0) -> JointTrajectoryMsg:
    """A trajectory as a message that starts at a stamp [ns], zero: on receipt."""
    message = JointTrajectoryMsg()
    message.header = header_to_ros(stamp_ns)
    message.joint_names = list(trajectory.names)
    velocities = trajectory.velocities
    none = np.empty((len(trajectory.times), 0))
    message.points = [
        JointTrajectoryPoint(
            positions=_doubles(row),
            velocities=_doubles(speeds),
            time_from_start=duration_to_ros(time),
        )
        for time, row, speeds in zip(
            trajectory.times.tolist(),
            trajectory.positions,
            none if velocities is None else velocities,
            strict=True,
        )
    ]
    return message


def trajectory_from_ros(message: JointTrajectoryMsg) -> JointTrajectory:
    """A trajectory of a message; velocities count where every point has them.

    Raises:
        ShoecalError: for points of other lengths than there are joints, times that do not
            increase, or numbers that are not finite.
    """
    names = tuple(message.joint_names)
    rows = [np.array(point.positions) for point in message.points]
    if not rows or any(row.shape != (len(names),) for row in rows):
        raise MessageError(
            f"joint_trajectory: every one of its {len(rows)} points must hold {len(names)} "
            "positions; correct its sender"
        )
    times = np.array([time_from_ros(point.time_from_start) for point in message.points])
    speeds = [np.array(point.velocities) for point in message.points]
    moving = all(speed.shape == (len(names),) for speed in speeds)
    return JointTrajectory(
        names, times / SECOND_NS, np.stack(rows), np.stack(speeds) if moving else None
    )


# Forces and places


def point_to_ros(stamp_ns: int, frame_id: str, point: Iterable[float]) -> PointStamped:
    """A point (2,) or (3,) [m] as a message."""
    message = PointStamped(header=header_to_ros(stamp_ns, frame_id))
    x, y, *z = map(float, point)
    message.point.x, message.point.y, message.point.z = x, y, z[0] if z else 0.0
    return message


def point_from_ros(message: PointStamped) -> FloatArray:
    """The point (3,) [m] of a message."""
    return np.array([message.point.x, message.point.y, message.point.z])


def wrench_to_ros(stamp_ns: int, frame_id: str, wrench: Iterable[float]) -> WrenchStamped:
    """A vertical floor wrench (3,) = F [N], Mx, My [N m] as a message."""
    message = WrenchStamped(header=header_to_ros(stamp_ns, frame_id))
    force, about_x, about_y = map(float, wrench)
    message.wrench.force.z = force
    message.wrench.torque.x = about_x
    message.wrench.torque.y = about_y
    return message


# Calibrations


def calibration_to_ros(calibration: Calibration, origin: Origin | None = None) -> ShoeCalibration:
    """A calibration as a message.

    Args:
        calibration: whole.
        origin: where it was made; None: as its time stamp says.
    """
    origin = origin or Origin.of(calibration)
    return ShoeCalibration(
        header=header_to_ros(calibration.made_ns),
        format=CALIBRATION_FORMAT,
        id=calibration.id,
        source=calibration.source,
        robot=calibration.robot,
        shoe=calibration.shoe,
        robot_hash=calibration.robot_hash,
        shoe_hash=calibration.shoe_hash,
        channel=list(calibration.channels),
        gain=_doubles(calibration.parameters.gain),
        offset=_doubles(calibration.parameters.offset),
        covariance=_doubles(_or_empty(calibration.covariance)),
        columns=_doubles(_or_empty(calibration.columns)),
        column_covariance=_doubles(_or_empty(calibration.column_covariance)),
        support_covariance=_doubles(_or_empty(calibration.support_covariance)),
        correction=_corrections_to_ros(calibration.corrections),
        weight=float(calibration.weight),
        time_offset=float(calibration.time_offset),
        temperature=float(calibration.temperature),
        verdict=calibration.verdict,
        reasons=list(calibration.reasons),
        fitted_runs=list(calibration.fitted_runs),
        simulated_time=origin.simulated,
        host=origin.host,
        device=origin.device,
    )


def origin_from_ros(message: ShoeCalibration) -> Origin:
    """Where a calibration was made, as its message says.

    Raises:
        MessageError: for a stamp of simulated time that is said to be none.
    """
    if not message.simulated_time and time_from_ros(message.header.stamp) < EPOCH_NS:
        raise MessageError(
            f"calibration '{message.id}' is dated before the year 2000 and not of simulated time; "
            "correct its stamp or simulated_time"
        )
    return Origin(message.simulated_time, short_name(message.host), short_name(message.device))


def calibration_from_ros(message: ShoeCalibration) -> Calibration:
    """A calibration of a message.

    Raises:
        ShoecalError: for anything missing or impossible, or another version of the layout.
    """
    if message.format != CALIBRATION_FORMAT:
        raise MessageError(
            f"calibration '{message.id}' has format {message.format}, known here is "
            f"{CALIBRATION_FORMAT}; use one version of shoecal on both sides"
        )
    count = len(message.channel)
    return Calibration(
        id=message.id,
        source=message.source,
        made_ns=time_from_ros(message.header.stamp),
        robot=message.robot,
        shoe=message.shoe,
        robot_hash=message.robot_hash,
        shoe_hash=message.shoe_hash,
        channels=tuple(message.channel),
        parameters=ChannelParameters(np.array(message.gain), np.array(message.offset)),
        covariance=_matrix(message, "covariance", (2 * count, 2 * count)),
        corrections=tuple(
            _correction_from_ros(correction)
            for correction in message.correction
            if correction.active
        ),
        weight=message.weight,
        time_offset=message.time_offset,
        temperature=message.temperature,
        verdict=message.verdict,
        reasons=tuple(message.reasons),
        fitted_runs=tuple(message.fitted_runs),
        columns=_matrix(message, "columns", (count, 3)),
        column_covariance=_matrix(message, "column_covariance", (3 * count, 5 * count)),
        support_covariance=_matrix(message, "support_covariance", (3, 3)),
    )


def _or_empty(matrix: FloatArray | None) -> FloatArray:
    return np.zeros(0) if matrix is None else matrix


def _matrix(message: ShoeCalibration, field: str, shape: tuple[int, int]) -> FloatArray | None:
    """A matrix row by row; None for an empty one."""
    values = np.array(getattr(message, field))
    if not len(values):
        return None
    size = shape[0] * shape[1]
    if len(values) != size:
        raise ShapeError(field, f"0 or {size} numbers", values.shape)
    return values.reshape(shape)


def _corrections_to_ros(
    corrections: Sequence[CopCorrection],
) -> list[shoecal_msg.CopCorrection]:
    """Empty, or one a foot."""
    if not corrections:
        return []
    messages = [shoecal_msg.CopCorrection(foot=foot, active=False) for foot in FEET]
    for correction in corrections:
        message = messages[correction.foot]
        message.active = True
        message.a, message.m = correction.x[:POLYNOMIAL], _doubles(correction.x[POLYNOMIAL:])
        message.b, message.n = correction.y[:POLYNOMIAL], _doubles(correction.y[POLYNOMIAL:])
        message.cop_min, message.cop_max = correction.cop_range
        message.force_min, message.force_max = map(_doubles, correction.output_range)
    return messages


def _correction_from_ros(message: shoecal_msg.CopCorrection) -> CopCorrection:
    if message.foot not in FEET:
        raise NameNotFoundError("foot", message.foot, FEET)
    if len(message.force_min) != len(message.force_max):
        raise ShapeError("force_max", f"({len(message.force_min)},)", (len(message.force_max),))
    return CopCorrection(
        foot=FEET.index(message.foot),
        x=np.concatenate((message.a, message.m)),
        y=np.concatenate((message.b, message.n)),
        cop_range=np.array([message.cop_min, message.cop_max], dtype=np.float64),
        output_range=np.array([message.force_min, message.force_max], dtype=np.float64),
    )


def _doubles(values: FloatArray) -> array.array[float]:
    """An array message field, without a Python object for every number."""
    doubles = array.array("d")
    doubles.frombytes(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return doubles
