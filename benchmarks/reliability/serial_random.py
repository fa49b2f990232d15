"""Random bytes on the serial line.

Random bytes go into both decoders, cut at random as reads of a port cut them: evenly drawn ones,
ones with many delimiters, with none, and printable ones. After every 10,000 bytes two good frames
come. Both decoders must raise nothing and hold no more than one frame (255 bytes) or line (1 kB);
the second good frame must be read (the first may be taken for the end of what came before).

No frame may be accepted that was not sent. A checksum of 32 bits lets one in 4.3e9 damaged packets
through, so the chance of a wrong frame is the packets that came as far as the checksum over 2^32;
the table tells both for the worst million bytes. Lines of text have no checksum: a line of eight
numbers cannot be told from a reading, so there only exceptions, bounds and the next good line are
looked at.

The bytes and the decoders are real; there is no port.
"""

from __future__ import annotations

import random

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import (
    CELLS,
    CHECKED,
    BrokenError,
    check_frames,
    checksums_failed,
    feed,
    frame,
)
from shoecal_ros.serial.frame import Frame
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame
from shoecal_ros.serial.text_protocol import TextDecoder

BLOCK = 10_000
TEXT = b"0123456789+-.,;=: \t\r\nenaifovf"


def noise(rng: np.random.Generator, count: int) -> bytes:
    """Random bytes of one of four sorts."""
    sort = rng.integers(4)
    drawn = rng.integers(0, 256, count, dtype=np.uint8)
    if sort == 1:
        drawn[rng.random(count) < 0.1] = 0
    elif sort == 2:
        drawn[drawn == 0] = 1
    elif sort == 3:
        drawn = np.frombuffer(TEXT, dtype=np.uint8)[drawn % len(TEXT)]
    return drawn.tobytes()


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Bytes `first` to `first + count - 1`, in blocks; a block that fails counts once."""
    binary, text = BinaryDecoder(), TextDecoder(columns=CELLS)
    failed, told, most = 0, "", 0
    for begin in range(first, first + count, BLOCK):
        size = min(BLOCK, first + count - begin)
        data = noise(np.random.default_rng([seed, begin]), size)
        rng = random.Random(begin)  # cuts and frames
        try:
            _block(binary, text, data, rng)
        except Exception as error:  # noqa: BLE001 - any exception is what is looked for
            failed, told = failed + 1, told or f"byte {begin}: {error!r}"
        most = max(most, binary.pending)
        progress(begin + size - first)
    reached = checksums_failed(binary)
    return Result(count, failed, told, counts={CHECKED: reached})


def _block(binary: BinaryDecoder, text: TextDecoder, data: bytes, rng: random.Random) -> None:
    good = [frame(rng, sequence) for sequence in (1, 2)]
    events = feed(binary, data + b"".join(map(encode_frame, good)), rng)
    check_frames(events, good, good[1:])
    line = b"\n" + b",".join(b"%d" % value for value in good[0].counts) + b"\n"
    lines = [event for event in feed(text, data + line, rng) if isinstance(event, Frame)]
    if not lines or lines[-1].counts != good[0].counts:
        raise BrokenError("the good line was not read")


ROW = Row(
    key="serial-random",
    fault="random serial bytes",
    holds="no exception, no wrong frame, bounded buffer, the next good frame is read",
    tries=100_000_000,
    step=1_000_000,
    run=run,
)
