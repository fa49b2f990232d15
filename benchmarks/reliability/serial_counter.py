"""A device on an open line restarts, and its counters jump.

One of these happens between good frames, without unplugging: the device restarts; its counter jumps
ahead, up to half its range, or goes over its end; frames are sampled but not sent; frames are
damaged on the line; its clock jumps ahead by up to 18,000 years; a frame comes twice. The frame
behind it must be read within 2 s, every frame that was sent whole must come out once, with a stamp
that is later than the one before and not more than a second from the present, and the frames
counted as lost must be those whose numbers are missing.

Bytes, terminal, driver and times are real; the device is simulated.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import PERIOD_US, BrokenError
from reliability.serial_line import Line, descriptors

BACK_S = 2.0
NEAR_NS = 10**9
UPTIME = 2000

Fault = Callable[[Line, random.Random], int]
"""Lets something happen; how many frames that loses."""


def restart(line: Line, rng: random.Random) -> int:
    """The power was off for a moment; then frames are lost."""
    line.sequence = line.time_us = 0
    return drop(line, rng)


def jump_ahead(line: Line, rng: random.Random) -> int:
    """The counter alone."""
    step = round(2 ** rng.uniform(0.0, 30.9))
    line.sequence = (line.sequence + step) % 2**32
    return step


def wrap(line: Line, rng: random.Random) -> int:
    """Over the end of the counter: first near to it, which nobody can tell from a restart there."""
    line.sequence = 2**32 - rng.randint(1, 50)
    line.sample()
    return drop(line, rng)


def drop(line: Line, rng: random.Random) -> int:
    """Frames that are sampled, but not sent."""
    count = rng.randint(0, 100)
    line.sample(count, send=False)
    return count


def damage(line: Line, rng: random.Random) -> int:
    """Bits of a frame flip on the line."""
    line.device.corrupt_next(*rng.sample(range(60), rng.randint(1, 3)))
    line.sample()
    return 1


def clock_ahead(line: Line, rng: random.Random) -> int:
    """The device's clock jumps, in the same read as what came before it, or not."""
    line.time_us += round(2 ** rng.uniform(0.0, 59.0))
    return 0


def twice(line: Line, _: random.Random) -> int:
    """The counter stands still for a frame; its time goes on."""
    line.sequence = (line.sequence - 1) % 2**32
    return 0


FAULTS = (restart, jump_ahead, wrap, drop, damage, clock_ahead, twice)


def _try(line: Line, fault: Fault, rng: random.Random) -> float:
    """Let it happen; seconds until a frame is read again."""
    readings, lost = line.reader.readings, line.reader.lost
    known, sent = len(readings), line.device.sent
    missing = fault(line, rng)
    back_s = line.until_read(BACK_S)
    line.sample(3)
    line.settle()
    whole = line.device.sent - sent - (fault is damage)
    if len(readings) - known != whole:
        raise BrokenError(f"{whole} frames were sent whole, {len(readings) - known} read")
    if line.reader.lost - lost != missing:
        raise BrokenError(f"{missing} frames were lost, {line.reader.lost - lost} counted")
    stamps, now = [one.stamp_ns for one in readings[known - 1 :]], time.time_ns()
    if any(after <= before for before, after in itertools.pairwise(stamps)):
        raise BrokenError("stamps go back")
    if max(abs(now - stamp) for stamp in stamps) > NEAR_NS + round(back_s * 1e9):
        raise BrokenError("a stamp is far from the present")
    return back_s


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One fault a try, each on a device that has run for a while."""
    failed, told, longest = 0, "", 0.0
    with Line() as line:
        line.until_read()
        held = descriptors()
        for index in range(first, first + count):
            rng = random.Random(seed * 2**40 + index)
            line.sequence, line.time_us = UPTIME, UPTIME * PERIOD_US
            line.sample()
            line.settle()
            fault = rng.choice(FAULTS)
            try:
                longest = max(longest, _try(line, fault, rng))
                if descriptors() > held:
                    raise BrokenError(f"{descriptors()} descriptors are open, {held} before")
            except BrokenError as error:
                failed, told = failed + 1, told or f"try {index}, {fault.__name__}: {error}"
            progress(index - first + 1)
    return Result(count, failed, told or f"{longest:.3f} s until back", longest)


ROW = Row(
    key="serial-counter",
    fault="device restarts, counters jump",
    holds="back within 2 s, stamps grow and are near the present, every lost frame counted",
    tries=10_000,
    step=500,
    run=run,
)
