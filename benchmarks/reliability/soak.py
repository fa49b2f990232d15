"""A long day of standing, in stretches of two hours.

The nodes `shoe_driver` and `calibrator` run as processes and read 100 frames of a robot second, the
first from a pseudo-terminal, the second over DDS, with joint angles and a clock that goes as fast
as they can follow. Four frames in a thousand are lost or damaged on the line. Every whole frame
must give one right CoP at a subscriber, and the frames that driver and calibrator count as lost
must be those that were not sent whole. Both processes are started anew for every stretch of two
hours, so that a run that was cut goes on where it was: what piles up only after more than two hours
is not seen. Each robot minute both processes' resident memory is noted; over a stretch, without its
first half hour, it must grow by less than 1 MB an hour (a straight line through the notes).
Stretches shorter than an hour are not judged by their memory.

Bytes, terminal, processes, DDS and memory are real; robot and time are simulated. What nodes do by
the clock on the wall, as telling diagnostics, comes more seldom in a robot hour than it will in a
real one. That inputs grow stale, which goes by that clock, too, is switched off (100 s): the robot
waits for the nodes here, and another row tries it. Planner, model and simulator do not run, nothing
is planned or recorded: how memory grows with that is not seen.
"""

from __future__ import annotations

import os
import random
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reliability.live_world import live_world
from reliability.row import Progress, Result, Row
from reliability.soak_robot import SoakRobot
from reliability.tries import BrokenError

MB = 1e6
MOST_MB = 1.0
"""An hour."""
MINUTE = 60
WARM, LONG = 30 * MINUTE, 60 * MINUTE
"""Seconds that are not looked at for memory, and from which on it is judged."""
LOOK = 10 * MINUTE
"""From one look at the lost frames to the next."""
LOST = "frames lost"


@dataclass(frozen=True)
class Stretch:
    """What came of some robot seconds of the same two processes.

    Attributes:
        failed: seconds in which something was wrong.
        told: the first of them, in words.
        lost: frames that did not go out whole.
        memory: of each process, one note after the other [MB].
    """

    failed: int
    told: str
    lost: int
    memory: Mapping[str, list[float]]


def stand(
    first: int, count: int, seed: int, progress: Progress, note_every: int = MINUTE
) -> Stretch:
    """Robot seconds, all of the same two processes.

    Args:
        first, count, seed, progress: as for the tries of a row.
        note_every: seconds from one note of the memory to the next.
    """
    failed, told = 0, ""
    memory: dict[str, list[float]] = {}
    with live_world() as world:
        robot = SoakRobot(world, random.Random(seed * 2**40 + first))
        for second in range(1, count + 1):
            wrong = robot.second()
            if not wrong and (second % LOOK == 0 or second == count):
                wrong = _miscounted(robot)
            if wrong:
                failed, told = failed + 1, told or f"second {first + second - 1}: {wrong}"
            if second % note_every == 0:
                for name, process in world.processes.items():
                    memory.setdefault(name, []).append(resident_mb(process.pid))
            progress(second)
        return Stretch(failed, told, robot.lost, memory)


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """A stretch, judged by its memory, too, where it is long."""
    found = stand(first, count, seed, progress)
    failed, told = found.failed, found.told
    if count < LONG:
        return Result(count, failed, told, counts={LOST: found.lost})
    growth = {name: an_hour(notes[WARM // MINUTE :]) for name, notes in found.memory.items()}
    most = max(growth.values())
    if most >= MOST_MB:
        failed, told = count, told or "memory grows"
    grown = ", ".join(f"{name} {mb:+.2f} MB" for name, mb in growth.items())
    told = "; ".join(filter(None, (told, f"an hour: {grown}")))
    return Result(count, failed, told, most, {LOST: found.lost})


def _miscounted(robot: SoakRobot) -> str:
    try:
        counted = robot.counted()
    except BrokenError as error:
        return str(error)
    if counted == (robot.lost, robot.lost):
        return ""
    return f"{robot.lost} frames lost; {counted[0]} counted by the driver, {counted[1]} behind it"


def resident_mb(process: int) -> float:
    """Memory that a process holds."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MB


def an_hour(notes: list[float]) -> float:
    """Growth an hour of one note a minute."""
    return MINUTE * float(np.polyfit(np.arange(len(notes)), notes, 1)[0])


ROW = Row(
    key="soak",
    fault="24 h of robot time at 100 Hz, by seconds",
    holds="every whole frame gives its CoP, every lost one is counted, memory grows < 1 MB an hour",
    tries=24 * 60 * MINUTE,
    step=2 * 60 * MINUTE,
    run=run,
)
