"""Every byte a device sent, kept in a file to look into or to replay."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.files import system_error
from shoecal_ros.common.codes import Code, Problem


class RawLog:
    """Appends bytes to a file; a full disk ends the log, not the driver.

    Attributes:
        problem: why nothing is logged any more, None when all is well.
    """

    def __init__(self, path: Path) -> None:
        self.problem: Problem | None = None
        self._path = path
        try:
            # Unbuffered: what was received is in the file, whatever happens next.
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise system_error(path, error, "cannot be written", "correct 'raw_log'") from error

    def write(self, data: bytes) -> None:
        """Append bytes."""
        if self.problem is not None:
            return
        try:
            self._file.write(data)
        except OSError as error:
            reported = (
                f"{self._path}: log of raw bytes ended ({error.strerror}); make room on its disk "
                "and start the driver again"
            )
            self.problem = Problem(Code.RAW_LOG_ENDED, reported)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
