"""Frames -> stamped voltages of cells: all that a node has to publish."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.serial.channel_map import CellReadings, ChannelMap
from shoecal_ros.serial.clock import DeviceClock
from shoecal_ros.serial.config import DriverConfig
from shoecal_ros.serial.frame import FaultKind, Frame, FrameFault
from shoecal_ros.serial.replay import ReplaySource
from shoecal_ros.serial.serial_source import SerialSource
from shoecal_ros.serial.source import ByteSource, SourceStatus

STANDS_S = 2.0
"""A host clock that shows one time for so long stands; a simulation may be slow."""


@dataclass(frozen=True)
class Reading:
    """What becomes one message of voltages.

    Attributes:
        stamp_ns: host time of sampling [ns].
        sequence: device counter.
        cells: names, voltages and statuses.
        temperature: [degC], NaN where there is no sensor.
    """

    stamp_ns: int
    sequence: int
    cells: CellReadings
    temperature: float


@dataclass(frozen=True)
class DriverStatus:
    """Condition of the driver.

    Attributes:
        source: port or log.
        clock_resets: how often device and host clock had to be matched again.
        clock_drift: seconds the host's clock gains on the device's in a second.
        clock_stands: whether the host's clock shows zero, or has shown one time for long.
        unknown: channels without a cell -> how often they came.
        unseen: cells that no frame has carried.
    """

    source: SourceStatus
    clock_resets: int
    clock_drift: float
    clock_stands: bool
    unknown: dict[int, int]
    unseen: tuple[str, ...]

    @property
    def problem(self) -> Problem | None:
        """What is wrong at the moment and its cure, None when all is well."""
        name = self.source.name
        if self.source.problem is not None:
            return self.source.problem
        if self.unknown:
            channels = ", ".join(map(str, self.unknown))
            reported = f"{name}: no cell for channel {channels}; add it to 'channels'"
            return Problem(Code.CHANNEL_WITHOUT_CELL, reported)
        if self.clock_stands:
            reported = (
                f"{name}: frames come, but the clock stands still; start what publishes /clock"
            )
            return Problem(Code.CLOCK_STANDS, reported)
        if self.unseen and self.source.counts.frames:
            cells = ", ".join(self.unseen)
            reported = f"{name}: the device sends nothing for {cells}; correct 'channels'"
            return Problem(Code.CELL_WITHOUT_CHANNEL, reported)
        return None


class SerialDriver:
    """Reads a source and stamps what it gives. One thread reads; status may come from others."""

    def __init__(self, source: ByteSource, channels: ChannelMap, latency_ns: int = 0) -> None:
        """A driver of a source, open or not; takes `latency_ns` off every stamp."""
        self._source, self._channels, self._latency_ns = source, channels, latency_ns
        self._clock = DeviceClock()
        self._clock_stands = False
        self._stands_at = (0, 0)

    def open(self) -> None:
        """Open the source now, to have its errors raised."""
        self._source.open()

    def read(self, timeout_s: float) -> list[Reading]:
        """Readings that have come, in order; waits at most `timeout_s` for some."""
        readings: list[Reading] = []
        batch: list[Frame] = []
        batch_ns = 0
        for received in self._source.read(timeout_s):
            event, receive_ns = received.event, received.receive_ns
            restarted = isinstance(event, FrameFault) and event.kind is FaultKind.RESTART
            if restarted or receive_ns != batch_ns:
                readings += self._readings(batch, batch_ns)
                batch, batch_ns = [], receive_ns
            if restarted:
                self._clock.restart()
            if isinstance(event, Frame):
                batch.append(event)
        return readings + self._readings(batch, batch_ns)

    def status(self) -> DriverStatus:
        """Condition of the driver."""
        return DriverStatus(
            source=self._source.status(),
            clock_resets=self._clock.resets,
            clock_drift=self._clock.drift,
            clock_stands=self._clock_stands,
            unknown=self._channels.unknown,
            unseen=self._channels.unseen,
        )

    def close(self) -> None:
        """Close the source."""
        self._source.close()

    def _stood_s(self, device_us: list[int], receive_ns: int) -> float:
        """For how long the host's clock has shown the same, by the device's [s]."""
        if not device_us:
            return 0.0
        at, since_us = self._stands_at
        if receive_ns != at or device_us[-1] < since_us:
            self._stands_at = receive_ns, device_us[-1]
            return 0.0
        return (device_us[-1] - since_us) / 1e6

    def _readings(self, frames: list[Frame], receive_ns: int) -> list[Reading]:
        """Readings of frames received together."""
        if not frames:
            return []
        times = [frame.device_time_us for frame in frames if frame.device_time_us is not None]
        self._clock_stands = receive_ns <= 0 or self._stood_s(times, receive_ns) > STANDS_S
        if receive_ns <= 0:
            return []
        if len(times) == len(frames):
            stamps = self._clock.stamps(times, receive_ns)
        else:
            # No two readings may share a stamp, though lines of one read share their receipt.
            stamps = [receive_ns + place for place in range(len(frames))]
        return [
            Reading(
                stamp_ns=stamp - self._latency_ns,
                sequence=frame.sequence,
                cells=self._channels.readings(frame),
                temperature=math.nan if frame.temperature is None else frame.temperature,
            )
            for frame, stamp in zip(frames, stamps, strict=True)
        ]


def open_driver(config: DriverConfig, now: Callable[[], int]) -> SerialDriver:
    """The driver of a configured device, or of a log of its bytes where `port` is a plain file.

    The port is opened by `open`, or by itself at the first read.

    Args:
        config: of the device.
        now: the host's clock [ns].

    Raises:
        FileError: when the log of raw bytes cannot be written.
        ReplayError: when the log to replay cannot be read.
    """
    source: ByteSource
    if Path(config.port).is_file():
        source = ReplaySource(Path(config.port), config.decoder(), now)
    else:
        source = SerialSource(
            config.port,
            config.baud,
            config.decoder(),
            now,
            alarm_s=config.alarm_s,
            raw_log=config.raw_log,
        )
    return SerialDriver(source, config.channel_map(), config.latency_ns)
