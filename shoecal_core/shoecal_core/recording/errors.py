"""What can be wrong with a recording."""

from __future__ import annotations

import re
from pathlib import Path

from shoecal_core.errors import FileError

_PYTHON = re.compile(r"""\w*\((['"])(.*?)\1,?\)|[\[\]{}]|: \((\d+, )+\d+\)""")
"""Names and bytes as Python shows them: ['a', 'b'], KeyError('a'), (1, 2)."""


def reason_of(error: BaseException) -> str:
    """What a library says of a file that it cannot read, without Python's way to write it."""
    text = "" if isinstance(error, KeyError) else _PYTHON.sub(r"\2", str(error))
    return text or "its content is not of its kind"


class RecordingError(FileError):
    """A recording that cannot be used: not read without doubt, or without what is needed of it."""


class SessionError(FileError):
    """A folder that is no session, or one without the runs that are needed."""


class DamagedError(RecordingError):
    """A recording that is cut, unfinished or altered; whole parts of it can be rescued."""

    def __init__(self, path: Path | str, reason: str) -> None:
        super().__init__(
            path,
            f"cut, unfinished or damaged ({reason}); `shoecal recover` saves what parts are whole",
        )


class HashMismatchError(RecordingError):
    """A run that was recorded with another robot or shoe than the session's.

    Attributes:
        recorded: SHA-256 in the run.
        present: SHA-256 of the session's file.
    """

    def __init__(self, path: Path | str, file: str, recorded: str, present: str) -> None:
        self.recorded = recorded
        self.present = present
        super().__init__(
            path,
            f"recorded with another {file} (SHA-256 {recorded[:12]}…, the session's is "
            f"{present[:12]}…); put the one it was recorded with back, or say --force where the "
            "change repairs the file",
        )
