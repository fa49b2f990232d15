"""Random bytes on the serial line.

Random bytes go into both decoders, cut at random as reads of a port cut them: evenly drawn ones,
ones with many delimiters, with none, and printable ones. After every 10,000 bytes two good frames
come. Both decoders must raise nothing and hold no more than one frame (255 bytes) or line (1 kB);
the second good frame must be read (the first may be taken for the end of what came before).

No frame may be accepted that was not sent. A checksum of 32 bits lets one in 4.3e9 damaged packets
through, so the chance of a wrong frame is the packets that came as far as the checksum over 2^32;
the table has their number. Lines of text have no checksum: a line of eight numbers cannot be told
from a reading, so there only exceptions, bounds and the next good line are looked at.

The bytes and the decoders are real; there is no port.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import CELLS, CHECKED, check_frames, checksums_failed, feed, frame
from reliability.tries import BrokenError, run_tries
from shoecal_ros.serial.frame import Frame
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame
from shoecal_ros.serial.text_protocol import TextDecoder

BLOCK = 10_000
"""Bytes that are drawn at once; a block that fails counts once."""
LONGEST = 4096
"""Bytes that are read at once."""
TEXT = b"0123456789+-.,;=: \t\r\nenaifovf"


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Bytes `first` to `first + count - 1`, in whole blocks."""
    binary, text = BinaryDecoder(), TextDecoder(columns=CELLS)

    def attempt(_: int, rng: np.random.Generator) -> None:
        data = noise(rng)
        good = [frame(rng, sequence) for sequence in (1, 2)]
        events = feed(binary, data + b"".join(map(encode_frame, good)), rng, LONGEST)
        check_frames(events, good, good[1:])
        line = "\n" + ",".join(map(str, good[0].counts)) + "\n"
        lines = feed(text, data + line.encode(), rng, LONGEST)
        read = [event.counts for event in lines if isinstance(event, Frame)]
        if read[-1:] != [good[0].counts]:
            raise BrokenError("the good line was not read")

    result = run_tries(
        attempt,
        first // BLOCK,
        -(-count // BLOCK),
        seed,
        lambda blocks: progress(blocks * BLOCK),
    )
    return replace(result, tried=count, counts={CHECKED: checksums_failed(binary)})


def noise(rng: np.random.Generator) -> bytes:
    """A block of random bytes of one of four sorts."""
    sort = rng.integers(4)
    drawn = rng.integers(0, 256, BLOCK, dtype=np.uint8)
    if sort == 1:
        drawn[rng.random(BLOCK) < 0.1] = 0
    elif sort == 2:
        drawn[drawn == 0] = 1
    elif sort == 3:
        drawn = np.frombuffer(TEXT, dtype=np.uint8)[drawn % len(TEXT)]
    return drawn.tobytes()


ROW = Row(
    key="serial-random",
    fault="random serial bytes",
    holds="no exception, no wrong frame, bounded buffer, the next good frame is read",
    tries=100_000_000,
    step=1_000_000,
    run=run,
)
