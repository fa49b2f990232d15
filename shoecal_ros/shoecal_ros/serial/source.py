"""Where frames come from: the protocol that a serial port and a replayed log share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from shoecal_ros.common.codes import Problem
from shoecal_ros.serial.frame import Event, Info, LinkCounts


@dataclass(frozen=True, slots=True)
class Received:
    """An event of the stream and the host's clock when its last byte was here [ns]."""

    event: Event
    receive_ns: int


@dataclass(frozen=True)
class SourceStatus:
    """Condition of a source.

    Attributes:
        name: port or file.
        connected: whether it is open.
        rate: good frames per second of late [Hz].
        age: since the last good frame [s], None before the first.
        counts: totals of the decoder.
        reconnects: how often the port was opened again.
        info: what the device says of itself, None before it did.
        problem: what is wrong at the moment and its cure, None when all is well.
    """

    name: str
    connected: bool
    rate: float
    age: float | None
    counts: LinkCounts
    reconnects: int
    info: Info | None
    problem: Problem | None


class ByteSource(Protocol):
    """One thread reads; status and close may come from others."""

    def open(self) -> None:
        """Open it now rather than at the first read, to have its errors raised."""

    def read(self, timeout_s: float) -> list[Received]:
        """What has come, in order; waits at most `timeout_s` for something to come."""

    def status(self) -> SourceStatus:
        """Condition of the source."""

    def close(self) -> None:
        """Give back what is held, once a read in progress has ended; no frame comes after."""
