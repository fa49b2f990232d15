"""Where lines of readings come from: a file or pipe, or a child process that hears the driver."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from shoecal_core.cli.manual_guide_frames import FrameParser, LineFrame, LineProblem
from shoecal_core.errors import FileUnreadableError, ShoecalError
from shoecal_core.files import read_error
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.workspace import ros_environment

_CHUNK = 1 << 16
_END_S = 10.0
"""How long the child may take to end."""


class FrameStream:
    """Frames of a file descriptor.

    Attributes:
        descriptor: to wait for.
        live: they come by themselves; else they wait in a file until somebody reads them.
        ended: nothing more comes.
    """

    def __init__(self, descriptor: int, shoe: Shoe, path: Path, *, live: bool) -> None:
        """Nothing received.

        Args:
            descriptor: open for reading.
            shoe: whose cells they are of.
            path: where they come from, for messages.
            live: see above.
        """
        self.descriptor = descriptor
        self.live = live
        self.ended = False
        self._path = path
        self._parser = FrameParser(shoe, path)
        self._rest = b""
        self._lines: deque[bytes] = deque()

    @property
    def waiting(self) -> bool:
        """Whether whole lines have been received that were not taken yet."""
        return bool(self._lines)

    def receive(self) -> None:
        """Read what there is; waits where there is nothing yet."""
        data = os.read(self.descriptor, _CHUNK)
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._lines += lines
        if not data:
            self.ended = True
            if self._rest:
                self._lines.append(self._rest)

    def frames(self) -> Iterator[LineFrame | LineProblem]:
        """Take what was received, line by line, as far as the caller likes.

        Raises:
            FileError: for a line that is none of these.
        """
        while self._lines:
            found = self._parser.parse(self._lines.popleft().decode(errors="replace"))
            if found is not None:
                yield found

    def complain(self) -> ShoecalError:
        """The error to raise when it has ended too early."""
        return FileUnreadableError(
            self._path, "has no more readings; what was read is kept: go on with another file"
        )


@contextmanager
def file_stream(path: Path, shoe: Shoe) -> Iterator[FrameStream]:
    """Lines of a file (read as they are wanted) or of a pipe (read as they come).

    Raises:
        FileError: when it cannot be opened.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError as error:
        raise read_error(path, error) from error
    try:
        kind = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(kind):
            problem = "is a folder; name a file or pipe with lines of readings"
            raise FileUnreadableError(path, problem)
        yield FrameStream(descriptor, shoe, path, live=not stat.S_ISREG(kind))
    finally:
        os.close(descriptor)


@contextmanager
def driver_stream(shoe: Shoe) -> Iterator[FrameStream]:
    """What the running driver publishes, by way of a child process that has ROS 2.

    Raises:
        ShoecalError: where there is no ROS 2 workspace.
    """
    command = [
        sys.executable, "-m", "shoecal_ros.voltage_stream",
        "--ros-args", "-p", f'shoe_file:="{shoe.path.absolute()}"',
    ]  # fmt: skip
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen(
            command,
            env=ros_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=said,
            # An interrupt from the terminal is for the guide, which ends the child.
            start_new_session=True,
        ) as child,
    ):
        assert child.stdout is not None, "it was asked for"
        try:
            yield _ChildStream(child, child.stdout.fileno(), shoe, said.fileno())
        finally:
            # Without a reader it cannot be held up by what it still has to write.
            child.stdout.close()
            child.send_signal(signal.SIGINT)
            try:
                child.wait(_END_S)
            except subprocess.TimeoutExpired:
                child.kill()


class _ChildStream(FrameStream):
    """What the child prints; what it says when it fails is the error."""

    def __init__(
        self, child: subprocess.Popen[bytes], descriptor: int, shoe: Shoe, said: int
    ) -> None:
        super().__init__(descriptor, shoe, Path("shoe/voltages"), live=True)
        self._child = child
        self._said = said

    def complain(self) -> ShoecalError:
        """Its last line."""
        self._child.wait()
        text = os.pread(self._said, _CHUNK, 0).decode(errors="replace")
        lines = text.strip().splitlines()
        return ShoecalError(lines[-1] if lines else "the readings of the driver have ended")
