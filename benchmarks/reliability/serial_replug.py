"""The device is unplugged and plugged in again.

A device sends frames over a pseudo-terminal that vanishes, often while frames are under way, and
appears again under the same name, up to a second and a half later. In between it went on counting,
or has lost its power and begins at 0. The driver must report the loss of the port within half a
second, read again within 2 s of the plugging in, hold no more descriptors than before, and count
every frame that it did not read: exactly those whose numbers are missing. (What a device that loses
its power sampled after the last frame it sent nobody can count; here it is nothing.)

Bytes, terminal, driver and times are real; the device is simulated.
"""

from __future__ import annotations

import time

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_line import Line, check_descriptors, descriptors
from reliability.tries import BrokenError, run_tries

BACK_S = 2.0
REPORTED_S = 0.5
LONGEST_S = 1.5
"""Unplugged for so long at most."""
UPTIME = 2000
"""Frames that a device has counted at least when it restarts: had it run for a shorter time than
passes until it is read again, its numbers would only go on."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One unplugging a try, all of one driver."""
    with Line() as line:
        line.until_read()
        line.settle()
        held = descriptors()

        def attempt(_: int, rng: np.random.Generator) -> float:
            line.device.plug()  # after a try that failed
            back_s = _try(line, rng)
            check_descriptors(held)
            return back_s

        return run_tries(attempt, first, count, seed, progress, "{:.2f} s until back")


def _try(line: Line, rng: np.random.Generator) -> float:
    """Unplug and plug in; seconds until a frame is read again."""
    begin, known, lost = line.sequence, len(line.readings), line.lost
    restarts, under_way = rng.random(2) < 0.5
    line.sample(int(rng.integers(1, 21)))
    if restarts:
        line.sample(UPTIME, send=False)
        line.sample()
    if restarts or not under_way:
        line.settle()
    line.device.unplug()
    line.read(lambda: not line.driver.status().source.connected, REPORTED_S)
    if "plug" not in (problem := str(line.driver.status().problem)):
        raise BrokenError(f"the loss is reported as '{problem}'")
    plugged = time.monotonic() + LONGEST_S * rng.random() ** 3
    line.read(lambda: time.monotonic() > plugged)
    sampled = line.sequence - begin
    if restarts:
        line.sequence = line.time_us = 0
    begin = line.sequence
    line.sample(int(rng.integers(201)), send=False)
    line.device.plug()
    back_s = line.until_read(BACK_S)
    line.sample(3)
    line.settle()
    sampled += line.sequence - begin
    missing = sampled - (len(line.readings) - known)
    if line.lost - lost != missing:
        raise BrokenError(f"{missing} frames were lost, {line.lost - lost} counted")
    return back_s


ROW = Row(
    key="serial-replug",
    fault="device unplugged and plugged in again",
    holds="told, back within 2 s, no leaked descriptor, every lost frame counted",
    tries=1000,
    step=20,
    run=run,
)
