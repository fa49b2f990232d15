"""Pieces that the tests of the serial side share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from zlib import crc32

from hypothesis import strategies as st

from shoecal_ros.serial.cobs import stuff
from shoecal_ros.serial.frame import Event, FaultKind, Frame, FrameFault, Info
from shoecal_ros.serial.serial_source import SerialSource
from shoecal_ros.serial.source import Received

INFO = Info(firmware="test 1.0", protocol_version=1, channels=2, rate=100.0)

MakeSource = Callable[..., SerialSource]
ReadUntil = Callable[[SerialSource, Callable[[list[Received]], bool]], list[Received]]


class Clock:
    """Time that goes on only when told to."""

    def __init__(self) -> None:
        self.seconds = 100.0

    def now_ns(self) -> int:
        return round(self.seconds * 1e9)

    def monotonic(self) -> float:
        return self.seconds


def frame(sequence: int, time_us: int | None = None) -> Frame:
    """A frame of two channels; 10 ms a frame."""
    time_us = sequence * 10_000 if time_us is None else time_us
    return Frame(sequence, time_us, (0, 1), (0, 0), (sequence % 1000, -3))


def frames(events: Iterable[Event | Received]) -> list[Frame]:
    plain = (each.event if isinstance(each, Received) else each for each in events)
    return [event for event in plain if isinstance(event, Frame)]


def kinds(events: Iterable[Event]) -> list[FaultKind]:
    return [event.kind for event in events if isinstance(event, FrameFault)]


def sealed(head: bytes) -> bytes:
    """A packet of any content with a right checksum, as it goes over the wire."""
    return stuff(head + crc32(head).to_bytes(4, "little")) + b"\0"


@st.composite
def any_frame(draw: st.DrawFn) -> Frame:
    """Any frame the binary protocol can carry."""
    index = draw(st.lists(st.integers(0, 255), min_size=1, max_size=32, unique=True))
    n = len(index)
    byte, i32 = st.integers(0, 255), st.integers(-(2**31), 2**31 - 1)
    return Frame(
        sequence=draw(st.integers(0, 2**32 - 1)),
        device_time_us=draw(st.integers(0, 2**64 - 1)),
        index=tuple(index),
        status=tuple(draw(st.lists(byte, min_size=n, max_size=n))),
        counts=tuple(draw(st.lists(i32, min_size=n, max_size=n))),
        temperature=draw(
            st.none()
            | st.integers(-(2**15) + 1, 2**15 - 1).map(lambda hundredths: hundredths / 100)
        ),
    )
