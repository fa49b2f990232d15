"""One run written in a thread of its own: a disk that takes its time holds no force up."""

from __future__ import annotations

import threading
from queue import SimpleQueue

from shoecal_core.errors import ShoecalError
from shoecal_core.recording.writer import RunWriter

MOST_WAITING = 100_000
"""Messages that a disk may be behind: more than a minute of them."""


class RunThread:
    """Writes what it is given, in order.

    Attributes:
        problem: why no more can be written; empty when all is well.
        counts: messages that were written, by topic.
    """

    def __init__(self, writer: RunWriter) -> None:
        """Begin, with a run that is open."""
        self.problem = ""
        self.counts: dict[str, int] = {}
        self._writer = writer
        self._waiting: SimpleQueue[tuple[str, bytes, int] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._write, daemon=True, name="run")
        self._thread.start()

    def put(self, topic: str, message: bytes, stamp_ns: int) -> None:
        """Have a message written."""
        if self.problem:
            return
        if self._waiting.qsize() >= MOST_WAITING:
            self.problem = f"{self._writer.part}: the disk does not keep up; record to a faster one"
            return
        self._waiting.put((topic, message, stamp_ns))

    def finish(self) -> RunWriter:
        """Wait until all is written; the run, still open."""
        self._waiting.put(None)
        self._thread.join()
        return self._writer

    def _write(self) -> None:
        while (waiting := self._waiting.get()) is not None:
            if self.problem:
                continue
            topic, message, stamp_ns = waiting
            try:
                self._writer.write(topic, message, stamp_ns)
            except ShoecalError as error:
                self.problem = str(error)
            else:
                self.counts[topic] = self.counts.get(topic, 0) + 1
