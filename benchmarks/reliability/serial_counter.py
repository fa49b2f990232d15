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
import time

import numpy as np

from reliability.row import Progress, Result, Row
from reliability.serial_bytes import PERIOD_US
from reliability.serial_line import Line, check_descriptors, descriptors
from reliability.tries import BrokenError, run_tries

BACK_S = 2.0
NEAR_NS = 10**9
UPTIME = 2000
"""Frames that the device has counted before."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One fault a try, each on a device that has run for a while."""
    with Line() as line:
        line.until_read()
        held = descriptors()

        def attempt(_: int, rng: np.random.Generator) -> float:
            line.sequence, line.time_us = UPTIME, UPTIME * PERIOD_US
            line.sample()
            line.settle()
            back_s = _try(line, FAULTS[rng.integers(len(FAULTS))], rng)
            check_descriptors(held)
            return back_s

        return run_tries(attempt, first, count, seed, progress, "{:.3f} s until back")


def _try(line: Line, fault: str, rng: np.random.Generator) -> float:
    """Let it happen; seconds until a frame is read again."""
    lost, known, sent = line.lost, len(line.readings), line.device.sent
    missing = _happen(line, fault, rng)
    back_s = line.until_read(BACK_S)
    line.sample(3)
    line.settle()
    whole = line.device.sent - sent - (fault == "damaged")
    if len(line.readings) - known != whole:
        raise BrokenError(f"{fault}: {whole} sent whole, {len(line.readings) - known} read")
    if line.lost - lost != missing:
        raise BrokenError(f"{fault}: {missing} frames were lost, {line.lost - lost} counted")
    stamps, now = [one.stamp_ns for one in line.readings[known - 1 :]], time.time_ns()
    if any(after <= before for before, after in itertools.pairwise(stamps)):
        raise BrokenError(f"{fault}: stamps go back")
    if max(abs(now - stamp) for stamp in stamps) > NEAR_NS + round(back_s * 1e9):
        raise BrokenError(f"{fault}: a stamp is far from the present")
    return back_s


FAULTS = ("restart", "counter ahead", "wrap", "dropped", "damaged", "clock ahead", "twice")


def _happen(line: Line, fault: str, rng: np.random.Generator) -> int:
    """Let a fault happen; how many frames that loses."""
    missing = 0
    if fault == "restart":
        line.sequence = line.time_us = 0
    elif fault == "counter ahead":
        missing = round(2 ** rng.uniform(0.0, 30.9))
        line.sequence = (line.sequence + missing) % 2**32
    elif fault == "wrap":
        # First near to the end of the counter: alone, that is the same as a restart there.
        line.sequence = 2**32 - int(rng.integers(1, 51))
        line.sample()
    elif fault == "damaged":
        missing = 1
        line.device.corrupt_next(*rng.choice(60, rng.integers(1, 4), replace=False).tolist())
        line.sample()
    elif fault == "clock ahead":
        line.time_us += round(2 ** rng.uniform(0.0, 59.0))
    elif fault == "twice":
        line.sequence = (line.sequence - 1) % 2**32
    if fault in ("restart", "wrap", "dropped"):
        missing = int(rng.integers(101))
        line.sample(missing, send=False)
    return missing


ROW = Row(
    key="serial-counter",
    fault="device restarts, counters jump",
    holds="back within 2 s, stamps grow and are near the present, every lost frame counted",
    tries=10_000,
    step=500,
    run=run,
)
