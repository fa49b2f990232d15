"""A driver that reads a simulated device on a pseudo-terminal; all in real time."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self

from reliability.serial_bytes import CELLS, PERIOD_US
from reliability.tries import BrokenError
from shoecal_ros.serial.channel_map import Converter, DeviceChannel
from shoecal_ros.serial.config import DriverConfig, Mode
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.driver import Reading, SerialDriver, open_driver
from shoecal_ros.serial.frame import FaultKind, Info
from shoecal_ros.serial.text_protocol import TextTime

INFO = Info("simulated 1.0", 1, CELLS, 100.0)
PERIOD_S = 0.002
"""How long the driver waits for bytes, and between frames that are sent until one is read."""
TIMEOUT_S = 10.0


class Line:
    """A device and a driver that reads it.

    Attributes:
        port: link of the device's terminal.
        device: sends the frames.
        driver: reads them.
        readings: what the driver has read.
        sequence, time_us: of the frame that is sampled next.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="shoecal_")
        self.port = Path(self._folder.name) / "port"
        self.device = SimulatedDevice(self.port, INFO)
        self.driver = self.another_driver()
        self.readings: list[Reading] = []
        self.sequence = self.time_us = 0

    def another_driver(self) -> SerialDriver:
        """A driver of the same port that has not opened it yet."""
        config = DriverConfig(
            port=str(self.port),
            baud=115200,
            mode=Mode.BINARY,
            text_time=TextTime.NONE,
            text_columns=CELLS,
            latency_ns=0,
            alarm_s=2.0,
            raw_log=None,
            channels=tuple(DeviceChannel(n, f"left/{n}", Converter(1e-6)) for n in range(CELLS)),
        )
        return open_driver(config, time.time_ns)

    def sample(self, count: int = 1, *, send: bool = True) -> None:
        """Sample frames, and send them if somebody listens."""
        for _ in range(count):
            if send:
                self.device.send(self.sequence, self.time_us, range(CELLS), [0] * CELLS)
            self.sequence = (self.sequence + 1) % 2**32
            self.time_us += PERIOD_US

    def read(
        self, done: Callable[[], bool], timeout_s: float = TIMEOUT_S, *, sampling: bool = False
    ) -> float:
        """Read until something is done, with `sampling` send a frame before each reading.

        Returns:
            How long that took [s].

        Raises:
            BrokenError: when it is not done in time.
        """
        began = time.monotonic()
        while not done():
            if time.monotonic() > began + timeout_s:
                problem = self.driver.status().problem
                raise BrokenError(f"waited {timeout_s:g} s in vain for frames or a loss: {problem}")
            if sampling:
                self.sample()
            self.readings += self.driver.read(PERIOD_S)
        return time.monotonic() - began

    def until_read(self, timeout_s: float = TIMEOUT_S) -> float:
        """Send frames until another one is read; how long that took [s]."""
        known = len(self.readings)
        return self.read(lambda: len(self.readings) > known, timeout_s, sampling=True)

    def settle(self) -> None:
        """Read all that was sent."""
        last = (self.sequence - 1) % 2**32
        self.read(lambda: bool(self.readings) and self.readings[-1].sequence == last)

    @property
    def lost(self) -> int:
        """Frames counted as lost."""
        return self.driver.status().source.counts.faults[FaultKind.LOST_FRAMES]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.driver.close()
        self.device.close()
        self._folder.cleanup()


def check_descriptors(held: int) -> None:
    """No file is open that was not before.

    Raises:
        BrokenError: more than `held` are.
    """
    if descriptors() > held:
        raise BrokenError(f"{descriptors()} descriptors are open, {held} before")


def descriptors() -> int:
    """How many files this process holds open."""
    return len(os.listdir("/proc/self/fd"))  # noqa: PTH208 - its own descriptor counts alike
