"""What a recorded run hands over: samples in time, validated, raw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording.info import RunInfo

GAP_S, GAP_MEANS = 0.1, 2.5
"""Intervals longer than this, and than so many mean ones, are gaps between samples."""

UNIT_TOLERANCE = 0.1
"""Lengths of quaternions that count differ from one by less."""


@dataclass(frozen=True)
class JointSamples:
    """Joint angles as the robot reported them.

    Attributes:
        time: (T,) since the run's start, increasing [s].
        names: m joints.
        position: (T, m) [rad]; NaN where a joint was not reported.
        effort: (T, m) [N m], NaN likewise; None where the robot reports none.
    """

    time: FloatArray
    names: tuple[str, ...]
    position: FloatArray
    effort: FloatArray | None

    def __post_init__(self) -> None:
        _check_time("joints", self.time)
        shape = (len(self.time), len(self.names))
        _check_shape("joints.position", self.position, shape)
        if self.effort is not None:
            _check_shape("joints.effort", self.effort, shape)

    @property
    def rate_hz(self) -> float:
        """Samples a second of one joint: drivers of legs and arms may have times of their own."""
        known = np.isfinite(self.position)
        return float(np.median([_rate(self.time[column]) for column in known.T] or [0.0]))


@dataclass(frozen=True)
class Readings:
    """Raw sensor readings; one row a sampling time.

    Attributes:
        time: (T,) since the run's start, increasing [s].
        names: n channels, in the shoe's order.
        value: (T, n) in the shoe's unit (for a six-axis sensor N and N m); NaN: none given.
        status: (T, n) constants of ShoeVoltages; NO_DATA where `value` is NaN.
        sequence: (T, n) device counter of the message the value came in; -1: none given.
        temperature: (T, n) of the device it came from [degC]; NaN: none given.
    """

    time: FloatArray
    names: tuple[str, ...]
    value: FloatArray
    status: NDArray[np.uint8]
    sequence: IntArray
    temperature: FloatArray

    def __post_init__(self) -> None:
        _check_time("readings", self.time)
        shape = (len(self.time), len(self.names))
        for name in ("value", "status", "sequence", "temperature"):
            _check_shape(f"readings.{name}", getattr(self, name), shape)

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return _rate(self.time)


@dataclass(frozen=True)
class CommandedTrajectory:
    """One JointTrajectory as it was commanded.

    Attributes:
        start: when it starts, since the run's start [s].
        names: m joints.
        time: (K,) of its points since `start` [s].
        position: (K, m) [rad].
        velocity: (K, m) [rad/s]; None where the message gives none.
    """

    start: float
    names: tuple[str, ...]
    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None = None

    def __post_init__(self) -> None:
        _check_time("trajectory", self.time)
        _check_shape("trajectory.position", self.position, (len(self.time), len(self.names)))
        if self.velocity is not None:
            _check_shape("trajectory.velocity", self.velocity, (len(self.time), len(self.names)))


@dataclass(frozen=True)
class PoseSamples:
    """Pose of the floating base in the world.

    Attributes:
        time: (T,) since the run's start, increasing [s].
        position: (T, 3) [m].
        quaternion: (T, 4) x y z w, of unit length.
    """

    time: FloatArray
    position: FloatArray
    quaternion: FloatArray

    def __post_init__(self) -> None:
        _check_time("base_pose", self.time)
        _check_shape("base_pose.position", self.position, (len(self.time), 3))
        _check_shape("base_pose.quaternion", self.quaternion, (len(self.time), 4))


@dataclass(frozen=True)
class ImuSamples:
    """Inertial measurements, in the sensor's frame.

    Attributes:
        time: (T,) since the run's start, increasing [s].
        frame: name of the sensor's frame.
        quaternion: (T, 4) x y z w; NaN where the sensor reports none.
        angular_velocity: (T, 3) [rad/s].
        linear_acceleration: (T, 3) [m/s^2].
    """

    time: FloatArray
    frame: str
    quaternion: FloatArray
    angular_velocity: FloatArray
    linear_acceleration: FloatArray

    def __post_init__(self) -> None:
        _check_time("imu", self.time)
        _check_shape("imu.quaternion", self.quaternion, (len(self.time), 4))
        _check_shape("imu.angular_velocity", self.angular_velocity, (len(self.time), 3))
        _check_shape("imu.linear_acceleration", self.linear_acceleration, (len(self.time), 3))


@dataclass(frozen=True)
class TemperatureSamples:
    """One thermometer: time (T,) since the run's start [s], value (T,) [degC]."""

    time: FloatArray
    value: FloatArray

    def __post_init__(self) -> None:
        _check_time("temperature", self.time)
        _check_shape("temperature.value", self.value, (len(self.time),))


@dataclass(frozen=True)
class Run:
    """One recorded run.

    Attributes:
        path: the file.
        info: what it says of itself.
        start_ns: stamp of its first joint angles or readings; every time counts from there.
        joints, readings: always there.
        commanded: trajectories in the order they were received.
        base_pose, imu, shoe_temperature: None where not recorded.
        notes: what was dropped or is missing, for a person to read.
    """

    path: Path
    info: RunInfo
    start_ns: int
    joints: JointSamples
    readings: Readings
    commanded: tuple[CommandedTrajectory, ...] = ()
    base_pose: PoseSamples | None = None
    imu: ImuSamples | None = None
    shoe_temperature: TemperatureSamples | None = None
    notes: tuple[str, ...] = ()


def _check_time(name: str, time: FloatArray) -> None:
    if time.ndim != 1 or time.size == 0:
        raise ShapeError(f"{name}.time", "(T,) with T > 0", time.shape)
    if not (np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0)):
        raise ShoecalError(f"{name}.time: must be finite and increase")


def _check_shape(name: str, array: NDArray[np.generic], shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise ShapeError(name, str(shape), array.shape)


def _rate(time: FloatArray) -> float:
    """Samples a second without the gaps: samples of one packet may be stamped shortly after each
    other, so a median interval would be that of the packets.
    """
    steps = np.diff(time)
    if not len(steps):
        return 0.0
    steps = steps[steps <= max(GAP_S, GAP_MEANS * float(np.mean(steps)))]
    return float(1.0 / np.mean(steps))
