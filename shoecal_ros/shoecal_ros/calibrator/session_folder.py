"""Sessions that a request names: folders in `sessions_dir`, and nothing else."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.errors import ShoecalError

LONGEST_NAME = 255
"""Of a file or folder [characters]."""


class NoSessionNameError(ShoecalError):
    """Anything but the plain name of a folder."""


def session_folder(sessions_dir: str, name: str) -> Path:
    """Folder of a session by its name: no request names a file.

    Raises:
        NoSessionNameError: for anything but a plain name.
    """
    sessions = Path(sessions_dir).expanduser()
    plain = name.isprintable() and len(name) <= LONGEST_NAME and "/" not in name
    if not plain or name in {"", ".", ".."}:
        raise NoSessionNameError(
            f"a session is named by its folder's name in {sessions}, without any path; put it "
            "there (a link does), or use the command shoecal with it"
        )
    return sessions / name
