"""What a node writes for people must not hold it up."""

from __future__ import annotations

import array
import contextlib
import faulthandler
import fcntl
import os
import select
import sys
import termios
import threading
import time
from collections.abc import Iterator

BYTES = 2**20
"""What waits for a reader; a node that starts writes some kilobytes."""
LAST_WORDS_S = 1.0
_STEP_S = 0.002


@contextlib.contextmanager
def log_pipe() -> Iterator[int]:
    """Within it, whatever is written to stderr waits in a pipe for who reads it.

    ROS writes log lines while it holds Python's lock: where they are not read (a paused terminal,
    a full pipe) or a disk is slow, no thread of the node would go on. Here they wait, and what the
    pipe cannot hold is lost. At the end what waits is written still, if somebody reads it.

    Yields:
        The descriptor of stderr itself.
    """
    sys.stderr.flush()
    shown = os.dup(2)
    held, into = os.pipe()
    # A user may have little left of what pipes may hold; it is then as large as they come.
    with contextlib.suppress(PermissionError):
        fcntl.fcntl(into, fcntl.F_SETPIPE_SZ, BYTES)
    os.set_blocking(into, False)
    os.dup2(into, 2)
    os.close(into)
    # After a crash nothing would copy what stands in the pipe.
    faulthandler.enable(shown)
    copier = _Copier(held, shown)
    copier.start()
    try:
        yield shown
    finally:
        sys.stderr.flush()
        os.dup2(shown, 2)
        copier.await_last(LAST_WORDS_S)
        faulthandler.disable()


class _Copier(threading.Thread):
    """Copies what comes from one descriptor to another for as long as the process lives."""

    def __init__(self, held: int, shown: int) -> None:
        super().__init__(daemon=True, name="log")
        self._held, self._shown = held, shown
        self._writing = False

    def run(self) -> None:
        # Who read it has gone: then nothing is shown any more.
        with contextlib.suppress(OSError):
            data = b" "
            while data:
                select.select([self._held], [], [])
                self._writing = True
                data = os.read(self._held, 65_536)
                rest = data
                while rest:
                    rest = rest[os.write(self._shown, rest) :]
                self._writing = False

    def await_last(self, at_most_s: float) -> None:
        """Until nothing waits, or it is not read."""
        end = time.monotonic() + at_most_s
        while self.is_alive() and (self._writing or self._waits) and time.monotonic() < end:
            time.sleep(_STEP_S)

    @property
    def _waits(self) -> bool:
        count = array.array("i", [0])
        fcntl.ioctl(self._held, termios.FIONREAD, count)
        return count[0] > 0
