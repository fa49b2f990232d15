"""Serialised messages as they came into a run file, from a little before it was asked to."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.schemas import JOINT_STATES, JOINT_TRAJECTORY
from shoecal_core.recording.writer import RunWriter
from shoecal_ros.calibrator.run_thread import RunThread


class Recorder:
    """Keeps the last while of all topics, and writes runs."""

    def __init__(self, now_ns: Callable[[], int], lead_s: float) -> None:
        """Nothing is kept before `stand_by`.

        Args:
            now_ns: the node's time [ns].
            lead_s: what came so long before `start` belongs to the run, too [s].
        """
        self._problem = ""
        self._now_ns = now_ns
        self._lead_ns = round(lead_s * 1e9)
        self._kept: deque[tuple[int, str, bytes]] = deque()
        # A motion's command belongs to its run however long ago it came.
        self._commands: list[tuple[int, bytes]] = []
        self._standing_by = False
        self._run: RunThread | None = None
        self._last: RunThread | None = None

    @property
    def recording(self) -> bool:
        """Whether a run is being written."""
        return self._run is not None

    @property
    def problem(self) -> str:
        """Why the run at hand cannot be written any more; empty when all is well."""
        return self._problem or ("" if self._last is None else self._last.problem)

    @problem.setter
    def problem(self, problem: str) -> None:
        self._problem, self._last = problem, self._run

    @property
    def counts(self) -> dict[str, int]:
        """Messages written of the run at hand, or of the last one, by topic."""
        return {} if self._last is None else self._last.counts

    def stand_by(self) -> None:
        """Keep from now on what comes."""
        self._forget()
        self._standing_by = True

    def take(self, topic: str, messages: Sequence[bytes]) -> None:
        """Take messages of a topic of the run's kind, in order."""
        if self._run is None and not self._standing_by:
            return
        now_ns = self._now_ns()
        if self._run is not None:
            for message in messages:
                self._run.put(topic, message, now_ns)
            return
        kept = self._kept
        kept.extend((now_ns, topic, message) for message in messages)
        # What is stamped later than now was kept before the clock was set back.
        while kept and not now_ns - self._lead_ns <= kept[0][0] <= now_ns:
            stamp_ns, old_topic, message = kept.popleft()
            if old_topic == JOINT_TRAJECTORY:
                self._commands.append((stamp_ns, message))

    def start(self, make: Callable[[], RunWriter]) -> None:
        """Write to a new run.

        Args:
            make: opens it, in another thread.
        """
        self._run = run = RunThread(make)
        self.problem = ""
        for stamp_ns, message in self._commands:
            run.put(JOINT_TRAJECTORY, message, stamp_ns)
        for stamp_ns, topic, message in self._kept:
            run.put(topic, message, stamp_ns)
        self._forget()

    def stop(self) -> None:
        """End the run; `finish` waits until it is whole."""
        self._last, self._run = self._run, None
        if self._last is not None:
            self._last.end(whole=True)

    def finish(self) -> None:
        """Wait until the run that was stopped is whole; in another thread, as it may take a while.

        Raises:
            ShoecalError: when not all of it could be written, or nothing was recorded at all.
        """
        self.settle()
        if self.problem:
            raise ShoecalError(self.problem)
        if not self.counts.get(JOINT_STATES):
            raise ShoecalError(
                "the motion was done but not recorded; see that the planner's feedback and "
                "joint_states reach the calibrator, and calibrate again"
            )

    def abandon(self) -> None:
        """End an interrupted run; what was recorded stays, unfinished. `settle` waits for that."""
        self._forget()
        if self._run is not None:
            self._run.end(whole=False)
            self._run = None

    def settle(self) -> None:
        """Wait until nothing is being written any more; likewise in another thread."""
        if self._last is not None:
            self._last.wait()

    def _forget(self) -> None:
        self._kept.clear()
        self._commands.clear()
        self._standing_by = False
