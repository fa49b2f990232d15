"""Frames to damage, and what a decoder must hold whatever it is fed."""

from __future__ import annotations

import random
from collections.abc import Sequence

from shoecal_ros.serial.cobs import MAX_PACKET
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.frame import Event, Fault, FaultKind, Frame
from shoecal_ros.serial.protocol import BinaryDecoder
from shoecal_ros.serial.text_protocol import MAX_LINE

CELLS = 8
PERIOD_US = 10_000
ESCAPE = 2.0**-32
"""Chance that a damaged packet passes a checksum of 32 bits."""
CHECKED = f"damaged packets came as far as the checksum, which lets one pass with {ESCAPE:.0e}"


class BrokenError(Exception):
    """What must hold does not."""


def frame(rng: random.Random, sequence: int, channels: int = CELLS) -> Frame:
    """A frame of random counts at its time."""
    return Frame(
        sequence=sequence,
        device_time_us=sequence * PERIOD_US,
        index=tuple(range(channels)),
        status=(0,) * channels,
        counts=tuple(rng.randrange(-(2**23), 2**23) for _ in range(channels)),
        temperature=rng.randrange(-2000, 6000) / 100,
    )


def feed(decoder: Decoder, data: bytes, rng: random.Random, longest: int = 4096) -> list[Event]:
    """Feed bytes in random pieces, as reads of a port cut them.

    Raises:
        BrokenError: when the decoder holds more than one frame's worth of bytes.
    """
    most = MAX_PACKET + 1 if isinstance(decoder, BinaryDecoder) else MAX_LINE
    events: list[Event] = []
    start = 0
    while start < len(data):
        end = start + rng.randint(1, longest)
        events += decoder.feed(data[start:end])
        start = end
        if decoder.pending > most:
            raise BrokenError(f"the decoder holds {decoder.pending} bytes")
    return events


def check_frames(events: Sequence[Event], sent: Sequence[Frame], must: Sequence[Frame]) -> None:
    """Only frames that were sent were accepted, and all of those that nothing damaged.

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


def lost(events: Sequence[Event]) -> int:
    """Frames that were told to be lost."""
    return sum(
        event.count
        for event in events
        if isinstance(event, Fault) and event.kind is FaultKind.LOST_FRAMES
    )
