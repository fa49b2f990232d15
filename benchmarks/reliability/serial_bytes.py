"""Frames to damage, and what a decoder must hold whatever it is fed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reliability.tries import BrokenError
from shoecal_ros.serial.cobs import MAX_PACKET
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.frame import Event, FaultKind, Frame
from shoecal_ros.serial.protocol import BinaryDecoder
from shoecal_ros.serial.text_protocol import MAX_LINE

CELLS = 8
PERIOD_US = 10_000
CHECKED = f"damaged packets came as far as the checksum, which lets one pass with {2.0**-32:.0e}"
"""Name of the count of bad checksums; a checksum of 32 bits misses one in 2^32."""


def frame(rng: np.random.Generator, sequence: int, channels: int = CELLS) -> Frame:
    """A frame of random counts at its time."""
    return Frame(
        sequence=sequence,
        device_time_us=sequence * PERIOD_US,
        index=tuple(range(channels)),
        status=(0,) * channels,
        counts=tuple(rng.integers(-(2**23), 2**23, channels).tolist()),
        temperature=int(rng.integers(-2000, 6000)) / 100,
    )


def feed(decoder: Decoder, data: bytes, rng: np.random.Generator, longest: int) -> list[Event]:
    """Feed bytes in random pieces of at most `longest`, as reads of a port cut them.

    Raises:
        BrokenError: when the decoder holds more than one frame or line.
    """
    most = MAX_PACKET + 1 if isinstance(decoder, BinaryDecoder) else MAX_LINE
    events: list[Event] = []
    while data:
        size = int(rng.integers(1, longest + 1))
        events += decoder.feed(data[:size])
        data = data[size:]
        if decoder.pending > most:
            raise BrokenError(f"the decoder holds {decoder.pending} bytes")
    return events


def check_frames(events: Sequence[Event], sent: Sequence[Frame], must: Sequence[Frame]) -> None:
    """Only frames that were sent are accepted, and all of those that nothing damaged.

    Raises:
        BrokenError: when it is not so.
    """
    found = [event for event in events if isinstance(event, Frame)]
    for one in found:
        if one not in sent:
            raise BrokenError(f"a frame that was not sent was accepted: {one}")
    for one in must:
        if one not in found:
            raise BrokenError(f"good frame {one.sequence} was not read")


def checksums_failed(decoder: Decoder) -> int:
    """Damaged packets that came as far as the checksum."""
    return decoder.counts.faults[FaultKind.BAD_CHECKSUM]
