"""A device on a real pseudo-terminal, and sources that read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ros.serial.helpers import INFO, Clock, MakeSource, ReadUntil
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.protocol import BinaryDecoder
from shoecal_ros.serial.serial_source import SerialSource
from shoecal_ros.serial.source import Received

READ_S = 0.05
READS = 1200
"""A busy machine may take this long for something that must come."""


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def link(tmp_path: Path) -> Path:
    return tmp_path / "port"


@pytest.fixture
def device(link: Path) -> Iterator[SimulatedDevice]:
    with SimulatedDevice(link, INFO) as device:
        yield device


@pytest.fixture
def make_source(link: Path, clock: Clock) -> Iterator[MakeSource]:
    sources = []

    def make(decoder: Decoder | None = None, raw_log: Path | None = None) -> SerialSource:
        source = SerialSource(
            str(link),
            115200,
            decoder or BinaryDecoder(),
            clock.now_ns,
            alarm_s=2.0,
            raw_log=raw_log,
            monotonic=clock.monotonic,
        )
        sources.append(source)
        return source

    yield make
    for source in sources:
        source.close()


@pytest.fixture
def read_until(clock: Clock) -> ReadUntil:
    """Read until a condition on all that was received holds; a vain read takes clock time."""

    def read(source: SerialSource, done: Callable[[list[Received]], bool]) -> list[Received]:
        received: list[Received] = []
        for _ in range(READS):
            got = source.read(READ_S)
            received += got
            if done(received):
                return received
            if not got:
                clock.seconds += READ_S
        raise AssertionError(f"waited in vain; {source.status()}")

    return read
