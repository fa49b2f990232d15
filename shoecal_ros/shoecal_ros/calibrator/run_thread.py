"""One run written in a thread of its own: a disk that takes its time holds no force up."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from queue import SimpleQueue

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.writer import RunWriter
from shoecal_ros.common.refusal import worded

MOST_WAITING = 100_000
"""Messages that a disk may be behind: more than a minute of them."""


class RunThread:
    """Makes a run, writes what it is given, in order, and finishes it.

    Attributes:
        problem: why it is not whole, or will not be; empty when all is well.
        counts: messages that were written, by topic.
    """

    def __init__(self, make: Callable[[], RunWriter]) -> None:
        """Begin.

        Args:
            make: opens the run.
        """
        self.problem = ""
        self.counts: dict[str, int] = {}
        self._whole = False
        self._waiting: SimpleQueue[tuple[str, bytes, int] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._work, args=(make,), daemon=True, name="run")
        self._thread.start()

    def put(self, topic: str, message: bytes, stamp_ns: int) -> None:
        """Have a message written."""
        if self.problem:
            return
        if self._waiting.qsize() >= MOST_WAITING:
            self.problem = "the disk of sessions_dir does not keep up; record to a faster one"
            return
        self._waiting.put((topic, message, stamp_ns))

    def end(self, *, whole: bool) -> None:
        """Have the run ended once all is written, finished or as an interrupted one."""
        self._whole = whole
        self._waiting.put(None)

    def wait(self) -> None:
        """Wait until it has ended."""
        self._thread.join()

    def _work(self, make: Callable[[], RunWriter]) -> None:
        try:
            writer = make()
            while (waiting := self._waiting.get()) is not None:
                if not self.problem:
                    self._write(writer, *waiting)
            if self._whole and not self.problem:
                writer.close()
            else:
                with contextlib.suppress(ShoecalError):  # the cause is reported by who ends it
                    writer.abandon()
        except Exception as error:  # noqa: BLE001 (it is reported nowhere else)
            self.problem = worded(error)

    def _write(self, writer: RunWriter, topic: str, message: bytes, stamp_ns: int) -> None:
        try:
            writer.write(topic, message, stamp_ns)
        except ShoecalError as error:
            self.problem = str(error)
        else:
            self.counts[topic] = self.counts.get(topic, 0) + 1
