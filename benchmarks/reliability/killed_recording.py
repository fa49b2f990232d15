"""A process that records is killed with SIGKILL at a random moment.

Each try is a process of its own with the calibrator's recorder, which records joint angles and
voltages at 100 Hz, in real time, into a run of a session. It is killed within three seconds, one in
three just as it finishes the run. The session is then opened and the run recovered and read. Lost
is the time from the last message that is in the file to the last that was given to the recorder.
Killed before the recorder has synced for the first time, a file may hold nothing that can be
rescued; that counts as lost time like any other. Not simulated: a loss of power, which also takes
what the kernel has not yet written.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from reliability import originals
from reliability.row import Progress, Result, Row
from reliability.spawning import Child, Order, served, wait_until
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.recover import recover, recovered_path
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator.recorder import Recorder

AT_ONCE = 10
"""Recorders that run at once: most of a try is waiting."""
LONGEST_S = 3.0
RATE = 100.0
MOST_LOST_S = 1.0
_LEAD_S = 0.5
_DIGITS = 6


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    failed, worst, figure = 0, "", 0.0
    order = {"first": first, "count": count, "seed": seed}
    for done, one in enumerate(served("killed_recording", order), start=1):
        bad = bool(one["problem"]) or one["lost"] > MOST_LOST_S
        if not failed and (bad or one["lost"] >= figure):
            worst = one["problem"] or f"{one['lost']:.2f} s lost"
        failed, figure = failed + bad, max(figure, one["lost"])
        progress(done)
    return Result(count, failed, worst, figure)


def serve(order: Order) -> Iterator[dict[str, Any]]:
    """Record, kill and recover, some at once."""
    originals.robot(), originals.sample(0)
    numbers = list(range(order["first"], order["first"] + order["count"]))
    for begin in range(0, len(numbers), AT_ONCE):
        with tempfile.TemporaryDirectory(prefix="shoecal-killed-") as folder:
            some = numbers[begin : begin + AT_ONCE]
            tries = [_Try(Path(folder) / str(number), order["seed"], number) for number in some]
            for one in sorted(tries, key=lambda one: one.kill_at):
                wait_until(one.kill_at)
                one.kill()
            yield from (one.verdict() for one in tries)


class _Try:
    """One recorder."""

    def __init__(self, folder: Path, seed: int, number: int) -> None:
        rng = np.random.default_rng([seed, number])
        self._folder = originals.session(folder).folder
        lasts = rng.uniform(0.0, LONGEST_S)
        stops = lasts - rng.uniform(0.0, 0.03) if rng.random() < 1 / 3 else 10.0 * LONGEST_S
        begun = time.monotonic()
        self.kill_at = begun + lasts
        self._child = Child(lambda tell: _record(self._folder, begun + stops, tell))
        self._told: list[int] = []

    def kill(self) -> None:
        told = self._child.kill()
        self._told = [int(word) for word in told.split()]

    def verdict(self) -> dict[str, Any]:
        """What is in the session after that."""
        try:
            lost = self._lost()
        except ShoecalError as error:
            return {"problem": f"refused: {error}", "lost": 0.0}
        except ValueError as error:
            return {"problem": str(error), "lost": 0.0}
        return {"problem": "", "lost": lost}

    def _lost(self) -> float:
        """Time that is lost [s].

        Raises:
            ShoecalError: when the session, or a file of it, cannot be read any more.
            ValueError: when it is read with other values than were recorded.
        """
        session = Session.open(self._folder)
        for path in session.unfinished:
            try:
                recover(path, recovered_path(path))
            except ShoecalError as error:
                if "rescued" not in str(error):
                    raise
        kept = 0
        for entry in session.runs:
            readings = session.read(entry.run).readings
            indices = readings.sequence[:, 0]
            kept = len(indices)
            wanted = np.stack([originals.volts(int(index)) for index in indices])
            if not np.array_equal(indices, np.arange(kept)):
                raise ValueError("readings within the recovered run are lost")
            if not np.array_equal(readings.value, wanted):
                raise ValueError("the recovered run holds other readings than were recorded")
        return max(0, len(self._told) - kept) / RATE


def _record(folder: Path, stop_at: float, tell: Callable[[bytes], None]) -> None:
    """Record for ever, or to a moment of the monotonic clock [s]."""
    begun_ns, begun = time.time_ns(), time.monotonic()
    recorder = Recorder(time.time_ns, _LEAD_S)
    recorder.stand_by()
    session = Session.open(folder)
    recorder.start(lambda: session.new_run("landmarks", originals.SUPPORT))
    index = 0
    while index == 0 or time.monotonic() < stop_at:
        wait_until(begun + index / RATE)
        for topic, data in originals.sample(index, begun_ns + round(index / RATE * 1e9)).items():
            recorder.take(topic, [data])
        tell(f"{index:{_DIGITS}d}\n".encode())
        index += 1
    recorder.stop()
    recorder.finish()
    time.sleep(10.0 * LONGEST_S)


ROW = Row(
    key="killed-recording",
    fault="kill -9 while recording",
    holds="every file recovers, at most 1 s lost",
    tries=200,
    step=20,
    run=run,
)
