"""Frames damaged on the serial line, one in four.

Of four good frames the second is damaged: bits are flipped, or a stretch of it (nothing, a few
bytes, or all to its end) is replaced by nothing, random bytes, a delimiter, bytes of its own or the
end of another frame, or several of these. They come in random pieces. No frame may be accepted that
was not sent; those before and after the damage must be read (the one directly behind it only if its
delimiter is still there); and exactly the missing ones must be counted as lost.

A burst of up to 32 bits within a packet is always found by the checksum; of all else it lets one in
4.3e9 through, so in a million tries the chance of a wrong frame is about 1e-4.

The bytes and the decoder are real; there is no port.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import CHECKED, check_frames, checksums_failed, feed, frame
from reliability.tries import BrokenError, run_tries
from shoecal_ros.serial.frame import FaultKind, Frame, FrameFault
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame

LONGEST = 64
"""Bytes that are read at once."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One damaged frame a try."""
    reached = 0

    def attempt(_: int, rng: np.random.Generator) -> None:
        nonlocal reached
        decoder = BinaryDecoder()
        try:
            _read_damaged(decoder, rng)
        finally:
            reached += checksums_failed(decoder)

    return replace(run_tries(attempt, first, count, seed, progress), counts={CHECKED: reached})


def _read_damaged(decoder: BinaryDecoder, rng: np.random.Generator) -> None:
    frames = [frame(rng, number, int(rng.choice((8, 8, 4, 1, 32)))) for number in range(4)]
    # What is put in may happen to be all of the other frame: then it was sent.
    other = frame(rng, 1, int(rng.integers(1, 33)))
    before, whole, *behind = map(encode_frame, frames)
    damaged = damage(whole, encode_frame(other), rng)
    events = feed(decoder, b"".join((before, damaged, *behind)), rng, LONGEST)
    delimited = damaged.endswith(b"\0") or not damaged
    check_frames(events, [*frames, other], [frames[0], *frames[2 if delimited else 3 :]])
    seen = [event.sequence for event in events if isinstance(event, Frame)]
    lost = sum(
        event.count
        for event in events
        if isinstance(event, FrameFault) and event.kind is FaultKind.LOST_FRAMES
    )
    if seen != sorted(seen) or lost != len({0, 1, 2, 3}.difference(seen)):
        raise BrokenError(f"{seen} were read of 0 to 3, and {lost} counted as lost")


def damage(whole: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """Bytes with one, two or four faults, never the same bytes; `other` is another frame's."""
    data = whole
    while data == whole:
        for _ in range(rng.choice((1, 1, 2, 4))):
            data = (_flipped if data and rng.random() < 0.3 else _replaced)(data, other, rng)
    return data


def _flipped(data: bytes, _: bytes, rng: np.random.Generator) -> bytes:
    flipped = bytearray(data)
    for bit in rng.integers(8 * len(data), size=rng.integers(1, 9)).tolist():
        flipped[bit // 8] ^= 1 << bit % 8
    return bytes(flipped)


def _replaced(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    start = int(rng.integers(len(data) + 1))
    end = (start, start + int(rng.integers(1, 13)), len(data))[rng.integers(3)]
    fillers = (
        b"",
        rng.bytes(int(rng.integers(1, 13))),
        b"\0",
        data[int(rng.integers(len(data) + 1)) :][: int(rng.integers(1, 41))],
        other[int(rng.integers(len(other))) :],
    )
    return data[:start] + fillers[rng.integers(len(fillers))] + data[end:]


ROW = Row(
    key="serial-mutated",
    fault="damaged serial frames",
    holds="no exception, no wrong frame, the next good frame is read, every lost one is counted",
    tries=1_000_000,
    step=20_000,
    run=run,
)
