"""Frames damaged on the serial line, one in four.

Of four good frames the second is damaged: bits flipped, one by one or in a burst, bytes changed,
put in, left out, doubled or swapped, delimiters put in, the end cut off, the end of another frame
put in its place, or several of these. They come in random pieces. No frame may be accepted that was
not sent; those before and after the damage must be read (the one directly behind it only if its
delimiter still stands); and exactly the missing ones must be counted as lost.

A burst of up to 32 bits within a packet is always found by the checksum; of all else it lets one in
4.3e9 through, so in a million tries the chance of a wrong frame is about 1e-4.

The bytes and the decoder are real; there is no port.
"""

from __future__ import annotations

import random
from collections.abc import Callable

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import (
    CHECKED,
    BrokenError,
    check_frames,
    checksums_failed,
    feed,
    frame,
    lost,
)
from shoecal_ros.serial.frame import Frame
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame

Mutation = Callable[[bytearray, random.Random, bytes], None]
"""Damages bytes; the last argument is another frame's."""
PROGRESS = 1000


def flip_bits(data: bytearray, rng: random.Random, _: bytes) -> None:
    for _bit in range(rng.randint(1, 8)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def burst(data: bytearray, rng: random.Random, _: bytes) -> None:
    start = rng.randrange(len(data))
    end = min(len(data), start + rng.randint(1, 12))
    data[start:end] = rng.randbytes(end - start)


def change(data: bytearray, rng: random.Random, _: bytes) -> None:
    data[rng.randrange(len(data))] = rng.randrange(256)


def put_in(data: bytearray, rng: random.Random, _: bytes) -> None:
    place = rng.randrange(len(data) + 1)
    data[place:place] = rng.randbytes(rng.randint(1, 8))


def leave_out(data: bytearray, rng: random.Random, _: bytes) -> None:
    start = rng.randrange(len(data))
    del data[start : start + rng.randint(1, 8)]


def double(data: bytearray, rng: random.Random, _: bytes) -> None:
    start = rng.randrange(len(data))
    data[start:start] = data[start : start + rng.randint(1, 40)]


def swap(data: bytearray, rng: random.Random, _: bytes) -> None:
    a, b = rng.randrange(len(data)), rng.randrange(len(data))
    data[a], data[b] = data[b], data[a]


def delimit(data: bytearray, rng: random.Random, _: bytes) -> None:
    data.insert(rng.randrange(len(data) + 1), 0)


def cut(data: bytearray, rng: random.Random, _: bytes) -> None:
    del data[rng.randrange(len(data)) :]


def splice(data: bytearray, rng: random.Random, other: bytes) -> None:
    data[rng.randrange(len(data)) :] = other[rng.randrange(len(other)) :]


MUTATIONS: tuple[Mutation, ...] = (
    flip_bits, burst, change, put_in, leave_out, double, swap, delimit, cut, splice,
)  # fmt: skip


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One damaged frame a try."""
    failed, told, reached = 0, "", 0
    for index in range(first, first + count):
        decoder = BinaryDecoder()
        try:
            _try(decoder, random.Random(seed * 2**40 + index))
        except Exception as error:  # noqa: BLE001 - any exception is what is looked for
            failed, told = failed + 1, told or f"frame {index}: {error!r}"
        reached += checksums_failed(decoder)
        if index % PROGRESS == 0:
            progress(index - first)
    return Result(count, failed, told, counts={CHECKED: reached})


def _try(decoder: BinaryDecoder, rng: random.Random) -> None:
    frames = [frame(rng, sequence, rng.choice((8, 8, 4, 1, 32))) for sequence in range(4)]
    # What is put in may happen to be all of the other frame: then it was sent.
    other = frame(rng, 1, rng.randint(1, 32))
    before, whole, *behind = map(encode_frame, frames)
    damaged = _damaged(whole, encode_frame(other), rng)
    events = feed(decoder, b"".join((before, damaged, *behind)), rng, 64)
    follows = damaged.endswith(b"\0") or not damaged
    check_frames(events, [*frames, other], [frames[0], *frames[2 if follows else 3 :]])
    seen = [event.sequence for event in events if isinstance(event, Frame)]
    missing = set(range(4)).difference(seen)
    if seen != sorted(seen) or lost(events) != len(missing):
        raise BrokenError(f"{seen} were read of 0 to 3, and {lost(events)} counted as lost")


def _damaged(whole: bytes, other: bytes, rng: random.Random) -> bytes:
    damaged = bytearray(whole)
    while damaged == whole:
        for mutation in rng.choices(MUTATIONS, k=rng.choice((1, 1, 2, 4))):
            if damaged:
                mutation(damaged, rng, other)
    return bytes(damaged)


ROW = Row(
    key="serial-mutated",
    fault="damaged serial frames",
    holds="no exception, no wrong frame, the next good frame is read, every lost one is counted",
    tries=1_000_000,
    step=20_000,
    run=run,
)
