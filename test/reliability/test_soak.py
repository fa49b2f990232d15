from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from reliability.live_world import live_world
from reliability.soak import Scene, an_hour, resident_mb
from reliability.soak_robot import SoakRobot
from reliability.tries import BrokenError

HELD = 64_000_000
HOLDER = f"""
import mmap
print("idle", flush=True)
input()
held = mmap.mmap(-1, {HELD})
for place in range(0, {HELD}, mmap.PAGESIZE):
    held[place] = 1
print("held", flush=True)
input()
"""
SECONDS, BEGINNING = 60, 10
KEPT_MB = 1.0
"""Two hundred bytes of each of the 5,000 frames after the beginning: a message that is kept is
more, a list of its eight numbers, too. What grows at any rate is a tenth of it."""


def test_nothing_is_lost_uncounted_and_no_frame_kept() -> None:
    with live_world() as world:
        scene = Scene(world)
        for number in range(SECONDS):
            scene.attempt(number, np.random.default_rng([0, number]))
            scene.note_memory()
        scene.robot.check_counted()
        assert scene.robot.lost > 0
    grown = {name: notes[-1] - notes[BEGINNING] for name, notes in scene.memory.items()}
    assert set(grown) == {"shoe_driver", "calibrator"}
    assert max(grown.values()) < KEPT_MB, grown


def test_a_frame_that_is_lost_uncounted_fails() -> None:
    with live_world() as world:
        robot = SoakRobot(world, np.random.default_rng(0))
        robot.second(np.random.default_rng(0))
        robot.lost -= 1
        with pytest.raises(BrokenError, match="counted by the driver"):
            robot.check_counted()


def test_growth_is_an_hour_s() -> None:
    minutes = np.arange(90)
    assert an_hour((50.0 + 2.5 * minutes / 60).tolist()) == pytest.approx(2.5)


def test_memory_of_a_process_is_in_mb() -> None:
    # Of a process that does nothing else: this one's own threads and imports would count.
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"idle\n"
        before = resident_mb(holder.pid)
        assert holder.stdin is not None
        holder.stdin.write(b"\n")
        holder.stdin.flush()
        assert holder.stdout.readline() == b"held\n"
        after = resident_mb(holder.pid)
        holder.communicate(b"\n")
    assert after - before == pytest.approx(HELD / 1e6, rel=0.05)
