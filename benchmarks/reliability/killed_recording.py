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
from functools import partial
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.child import Child, Steps
from reliability.recovered import recovered_samples
from reliability.row import Progress, Result, Row, merge
from reliability.tries import BrokenError, run_tries
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator.recorder import Recorder

AT_ONCE = 10
"""Recorders that run at once: most of a try is waiting."""
LONGEST_S = 3.0
FINISHES_S = 0.03
"""A recorder that finishes its run does so at most this long before it is killed."""
RATE = 100.0
MOST_LOST_S = 1.0
LEAD_S = 0.5


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Record, kill and recover, some at once."""
    originals.robot(), originals.sample(0)  # cached before the forks
    end, results = first + count, []
    for begin in range(first, end, AT_ONCE):
        numbers = range(begin, min(begin + AT_ONCE, end))
        results.append(_at_once(numbers, seed))
        progress(numbers.stop - first)
    return merge(results)


def _at_once(numbers: range, seed: int) -> Result:
    with tempfile.TemporaryDirectory(prefix="shoecal-killed-") as name:
        recordings = [
            _Recording(Path(name) / str(number), np.random.default_rng([seed, number]))
            for number in numbers
        ]
        for one in sorted(recordings, key=lambda one: one.kill_at):
            one.kill()
        return run_tries(
            lambda number, _: recordings[number - numbers[0]].lost_s(),
            numbers[0],
            len(numbers),
            seed,
            lambda _: None,
            "{:.2f} s lost",
        )


class _Recording:
    """A recorder that is killed.

    Attributes:
        kill_at: when [s of the monotonic clock].
    """

    def __init__(self, folder: Path, rng: np.random.Generator) -> None:
        self._folder = originals.session(folder).folder
        self.kill_at = time.monotonic() + rng.uniform(0.0, LONGEST_S)
        finishes = rng.random() < 1 / 3
        stop_at = self.kill_at - rng.uniform(0.0, FINISHES_S) if finishes else np.inf
        self._child = Child(partial(_record, self._folder, stop_at))
        self._given = 0

    def kill(self) -> None:
        _wait_until(self.kill_at)
        self._given = self._child.kill()

    def lost_s(self) -> float:
        """Time that is lost [s].

        Raises:
            ShoecalError: when the session, or a file of it, cannot be read any more.
            BrokenError: when it is too long, or the rest is not what was recorded.
        """
        kept = recovered_samples(Session.open(self._folder))
        lost_s = max(0, self._given - kept) / RATE
        if lost_s > MOST_LOST_S:
            raise BrokenError(f"{lost_s:.2f} s lost")
        return lost_s


def _wait_until(moment: float) -> None:
    time.sleep(max(0.0, moment - time.monotonic()))


def _record(folder: Path, stop_at: float, given: Steps) -> None:
    """Record until a moment of the monotonic clock [s]; count the samples given to the recorder."""
    begun_ns, begun = time.time_ns(), time.monotonic()
    recorder = Recorder(time.time_ns, LEAD_S)
    recorder.stand_by()
    session = Session.open(folder)
    recorder.start(lambda: session.new_run("landmarks", originals.SUPPORT))
    while given.value == 0 or time.monotonic() < stop_at:
        index = given.value
        _wait_until(begun + index / RATE)
        for topic, data in originals.sample(index, begun_ns + round(index / RATE * 1e9)).items():
            recorder.take(topic, [data])
        given.value += 1
    recorder.stop()
    recorder.finish()
    time.sleep(10.0 * LONGEST_S)  # until it is killed


ROW = Row(
    key="killed-recording",
    fault="kill -9 while recording",
    holds="every file recovers, at most 1 s lost",
    tries=200,
    step=20,
    run=run,
)
