"""A long day of standing, in stretches of two hours.

The nodes `shoe_driver` and `calibrator` run as processes and read 100 frames of a robot second, the
first from a pseudo-terminal, the second over DDS, with joint angles and a clock that goes as fast
as they can follow. Four frames in a thousand are lost or damaged on the line. Every whole frame
must give one right CoP at a subscriber, and the frames that driver and calibrator count as lost
must be those that were not sent whole. Both processes are started anew for every stretch of two
hours, so that a run that was cut goes on where it was: what piles up only after more than two hours
is not seen. Each robot minute both processes' resident memory is noted; over a stretch, without its
first half hour, it must grow by less than 1 MB an hour (a straight line through the notes).
Shorter stretches are not judged by their memory. A second that fails ends its stretch.

Bytes, terminal, processes, DDS and memory are real; robot and time are simulated. What nodes do by
the clock on the wall, as publishing diagnostics, comes more seldom in a robot hour than it will in
a real one. That inputs grow stale, which goes by that clock, too, is switched off (100 s): the
robot waits for the nodes here, and another row tries it. Planner, model and simulator do not run,
nothing is planned or recorded: how memory grows with that is not seen.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from reliability.live_world import World, live_tries
from reliability.row import Progress, Result, Row
from reliability.soak_robot import SoakRobot

MB = 1e6
MOST_MB = 1.0
"""An hour."""
MINUTE = 60
STRETCH, WARM = 120 * MINUTE, 30 * MINUTE
"""Seconds that the same processes run, and those that are not looked at for memory."""
LOOK = 10 * MINUTE
"""From one look at the lost frames to the next."""


class Scene:
    """A robot that stands, its driver and its calibrator.

    Attributes:
        memory: of each process, one note a robot minute [MB].
    """

    def __init__(self, world: World) -> None:
        self.robot = SoakRobot(world, np.random.default_rng(0))
        self.memory: dict[str, list[float]] = {name: [] for name in world.processes}
        self._world = world
        self._seconds = 0

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """A second; growth of the memory in a whole stretch at its end [MB/h], else 0."""
        del number
        self.robot.second(rng)
        self._seconds += 1
        if self._seconds % MINUTE == 0:
            self.note_memory()
        if self._seconds % LOOK == 0:
            self.robot.check_counted()
        if self._seconds < STRETCH:
            return 0.0
        return max(an_hour(notes[WARM // MINUTE :]) for notes in self.memory.values())

    def note_memory(self) -> None:
        """Note the memory of each process."""
        for name, notes in self.memory.items():
            notes.append(resident_mb(self._world.processes[name].pid))


def resident_mb(process: int) -> float:
    """Memory that a process holds."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MB


def an_hour(notes: list[float]) -> float:
    """Growth an hour of one note a minute."""
    return MINUTE * float(np.polyfit(np.arange(len(notes)), notes, 1)[0])


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Seconds of the same two processes."""
    worst = "memory grows by {:.2f} MB an hour" if count == STRETCH else ""
    return live_tries(Scene, first, count, seed, progress, worst, MOST_MB)


ROW = Row(
    key="soak",
    fault="24 h of robot time at 100 Hz, by seconds",
    holds="every whole frame gives its CoP, every lost one is counted, memory grows < 1 MB an hour",
    tries=12 * STRETCH,
    step=STRETCH,
    run=run,
)
