"""A program in a real pseudo-terminal, and who sits before it."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Self

TIMEOUT_S = 60.0
_CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Terminal:
    """Runs `shoecal …`; everything it shows is kept in `seen`.

    Attributes:
        process: that runs in it.
        seen: what was shown, without control sequences.
    """

    def __init__(self, words: Sequence[object]) -> None:
        self._master, self._slave = pty.openpty()
        fcntl.ioctl(self._slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 160, 0, 0))
        self.before = termios.tcgetattr(self._slave)
        self.seen = ""
        self._raw = b""
        self._at = 0
        self.process = subprocess.Popen(
            [sys.executable, "-m", "shoecal_core.cli", *map(str, words)],
            stdin=self._slave,
            stdout=self._slave,
            stderr=self._slave,
            env={**os.environ, "TERM": "xterm"},
            # The terminal's interrupt reaches only who has it as controlling terminal.
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # noqa: PLW1509
        )

    def shows(self, pattern: str) -> bool:
        """Whether a text has come behind the one that was waited for; does not wait."""
        while self._receive(0.0):
            pass
        return re.compile(pattern).search(self.seen, self._at) is not None

    def until(self, pattern: str) -> re.Match[str]:
        """Wait for a text behind the one that was waited for before."""
        deadline = time.monotonic() + TIMEOUT_S
        while True:
            found = re.compile(pattern).search(self.seen, self._at)
            if found:
                self._at = found.end()
                return found
            left = deadline - time.monotonic()
            assert left > 0, f"waited in vain for {pattern!r}:\n{self.seen}"
            assert self._receive(left), f"ended before {pattern!r}:\n{self.seen}"

    def press(self, keys: str) -> None:
        """Press keys."""
        os.write(self._master, keys.encode())

    def wait(self) -> int:
        """Wait for the program's end; its exit code."""
        deadline = time.monotonic() + TIMEOUT_S
        # What it writes must be taken, or it could not end.
        while self.process.poll() is None:
            assert time.monotonic() < deadline, f"does not end:\n{self.seen}"
            self._receive(0.02)
        while self._receive(0.0):
            pass
        return self.process.returncode

    @property
    def attributes(self) -> list[object]:
        """Of the terminal now, as `before`."""
        return termios.tcgetattr(self._slave)

    def _receive(self, timeout_s: float) -> bool:
        if not select.select([self._master], [], [], timeout_s)[0]:
            return timeout_s > 0.0 and self.process.poll() is None
        self._raw += os.read(self._master, 1 << 16)
        self.seen = _CONTROL.sub("", self._raw.decode(errors="replace"))
        return True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._slave)
        os.close(self._master)
