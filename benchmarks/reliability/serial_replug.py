"""The device is unplugged and plugged in again.

A device sends frames over a pseudo-terminal that vanishes, often while frames are under way, and
appears again under the same name, up to a second and a half later. In between it went on counting,
or has lost its power and begins at 0. The driver must tell at once that the port is lost, read
again within 2 s of the plugging in, hold no more descriptors than before, and count every frame
that it did not read: exactly those whose numbers are missing. (What a device that loses its power
sampled after the last frame it sent nobody can count; here it is nothing.)

Bytes, terminal, driver and times are real; the device is simulated.
"""

from __future__ import annotations

import random
import time

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import BrokenError
from reliability.serial_line import Line, descriptors

BACK_S = 2.0
TOLD_S = 0.5
LONGEST_S = 1.5
UPTIME = 2000
"""Frames that a device has counted at least when it restarts: had it run for a shorter time than
passes until it is read again, its numbers would only go on."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One unplugging a try, all of one driver."""
    failed, told, longest = 0, "", 0.0
    with Line() as line:
        line.until_read()
        line.settle()
        held = descriptors()
        for index in range(first, first + count):
            try:
                back_s = _try(line, random.Random(seed * 2**40 + index), held)
                longest = max(longest, back_s)
                if back_s > BACK_S:
                    raise BrokenError(f"{back_s:.1f} s until back")
            except BrokenError as error:
                failed, told = failed + 1, told or f"try {index}: {error}"
                line.device.plug()
            progress(index - first + 1)
    return Result(count, failed, told or f"{longest:.2f} s until back", longest)


def _try(line: Line, rng: random.Random, held: int) -> float:
    """Unplug and plug in; seconds until a frame is read again."""
    begin, restarts = line.sequence, rng.random() < 0.5
    known, lost = len(line.reader.readings), line.reader.lost
    line.sample(rng.randint(1, 20))
    if restarts:
        line.sample(UPTIME, send=False)
        line.sample()
        line.settle()
    line.device.unplug()
    if not line.reader.wait(lambda: not _connected(line), TOLD_S):
        raise BrokenError(f"the loss was not told within {TOLD_S} s")
    if "plug" not in (problem := str(line.reader.driver.status().problem)):
        raise BrokenError(f"the loss is told as '{problem}'")
    time.sleep(LONGEST_S * rng.random() ** 3)
    before = line.sequence
    if restarts:
        line.restart()
    line.sample(rng.randint(0, 200), send=False)
    line.device.plug()
    back_s = line.until_read()
    line.sample(3)
    line.settle()
    sampled = line.sequence + (before if restarts else 0) - begin
    missing = sampled - (len(line.reader.readings) - known)
    counted = line.reader.lost - lost
    if counted != missing:
        raise BrokenError(f"{missing} frames were lost, {counted} counted")
    if descriptors() > held:
        raise BrokenError(f"{descriptors()} descriptors are open, {held} before")
    return back_s


def _connected(line: Line) -> bool:
    return line.reader.driver.status().source.connected


ROW = Row(
    key="serial-replug",
    fault="device unplugged and plugged in again",
    holds="told, back within 2 s, no leaked descriptor, every lost frame counted",
    tries=1000,
    step=20,
    run=run,
)
