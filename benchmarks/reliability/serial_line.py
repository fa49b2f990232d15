"""A driver that reads a simulated device on a pseudo-terminal, in a thread as its node does."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from reliability.serial_bytes import CELLS, PERIOD_US, BrokenError
from shoecal_ros.serial.channel_map import Channel, Converter
from shoecal_ros.serial.config import DriverConfig, Mode
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.driver import Reading, ShoeDriver, open_driver
from shoecal_ros.serial.frame import FaultKind, Info
from shoecal_ros.serial.text_protocol import TextTime

INFO = Info("simulated 1.0", 1, CELLS, 100.0)
READ_S = 0.1
PERIOD_S = 0.002
"""Between frames, in real time."""
TIMEOUT_S = 10.0


def descriptors() -> int:
    """How many files this process holds open."""
    return len(os.listdir("/proc/self/fd"))  # noqa: PTH208 - its own descriptor counts alike


def line_config(port: Path) -> DriverConfig:
    """A driver's configuration for such a device."""
    return DriverConfig(
        port=str(port),
        baud=115200,
        mode=Mode.BINARY,
        text_time=TextTime.NONE,
        text_columns=CELLS,
        latency_ns=0,
        alarm_s=2.0,
        raw_log=None,
        channels=tuple(Channel(n, f"left/{n}", Converter(1e-6)) for n in range(CELLS)),
    )


class Reader:
    """A driver and the thread that reads it.

    Attributes:
        readings: what it gave.
    """

    def __init__(self, driver: ShoeDriver) -> None:
        self.driver = driver
        self.readings: list[Reading] = []
        self._news = threading.Condition()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until something holds; looked at whenever something was read."""
        with self._news:
            return self._news.wait_for(condition, timeout_s)

    def has(self, sequence: int) -> bool:
        """Whether the last frame was this one."""
        return bool(self.readings) and self.readings[-1].sequence == sequence

    @property
    def lost(self) -> int:
        """Frames counted as lost."""
        return self.driver.status().source.counts.faults[FaultKind.LOST_FRAMES]

    def close(self) -> None:
        """Stop reading."""
        self._closing.set()
        self.driver.close()
        self._thread.join()

    def _read(self) -> None:
        while not self._closing.is_set():
            readings = self.driver.read(READ_S)
            with self._news:
                self.readings += readings
                self._news.notify_all()


class Line:
    """A device and a driver that reads it.

    Attributes:
        sequence, time_us: of the frame that is sampled next.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="shoecal_")
        self.port = Path(self._folder.name) / "port"
        self.device = SimulatedDevice(self.port, INFO)
        self.reader = Reader(open_driver(line_config(self.port), time.time_ns))
        self.sequence = self.time_us = 0

    def sample(self, count: int = 1, *, send: bool = True) -> None:
        """Sample frames, and send them if somebody listens."""
        for _ in range(count):
            if send:
                self.device.send(self.sequence, self.time_us, range(CELLS), [0] * CELLS)
            self.sequence = (self.sequence + 1) % 2**32
            self.time_us += PERIOD_US

    def restart(self) -> None:
        """The device begins anew."""
        self.sequence = self.time_us = 0

    def until_read(self, timeout_s: float = TIMEOUT_S) -> float:
        """Sample and send until a frame has been read; how long that took [s].

        Raises:
            BrokenError: when none is within the time.
        """
        known, began = len(self.reader.readings), time.monotonic()
        while not self.reader.wait(lambda: len(self.reader.readings) > known, PERIOD_S):
            self.sample()
            if time.monotonic() - began > timeout_s:
                problem = str(self.reader.driver.status().problem)
                raise BrokenError(f"nothing read for {timeout_s:g} s: {problem}")
        return time.monotonic() - began

    def settle(self) -> None:
        """Wait for the last frame that was sent.

        Raises:
            BrokenError: when it does not come.
        """
        last = (self.sequence - 1) % 2**32
        if not self.reader.wait(lambda: self.reader.has(last), TIMEOUT_S):
            raise BrokenError(f"frame {last} was sent, but not read")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.reader.close()
        self.device.close()
        self._folder.cleanup()
