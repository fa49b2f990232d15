"""A small disk that can be filled up and made read-only.

It is a tmpfs where one may be mounted. Elsewhere it is a folder: the size of files is limited
instead of the room, and rights are taken away instead of a read-only mount.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import shutil
import subprocess
from pathlib import Path
from typing import Self

SIZE_KIB = 1024
NOBODY = 65534
CLONE_NEWNS = 0x20000
"""Of sched.h: a mount namespace of its own."""


def hide_mounts() -> None:
    """Let nobody else see what this process mounts; without the right to mount it does nothing."""
    # os.unshare is there from Python 3.12 on.
    if ctypes.CDLL(None).unshare(CLONE_NEWNS) == 0:
        subprocess.run(["mount", "--make-rprivate", "/"], check=True)


class SmallDisk:
    """A disk that lasts as long as a `with` block.

    Attributes:
        folder: of it.
        mounted: whether it is a tmpfs.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.mounted = False
        self._filler = folder / "filler"

    def __enter__(self) -> Self:
        command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE_KIB}k", "tmpfs", str(self.folder)]
        with contextlib.suppress(OSError):
            self.mounted = not subprocess.run(command, check=False, capture_output=True).returncode
        return self

    def __exit__(self, *_: object) -> None:
        self.mend()
        if self.mounted:
            subprocess.run(["umount", self.folder], check=True)

    def fill(self, left: int) -> None:
        """Leave so many bytes free."""
        if not self.mounted:
            _limit_files(left)
            return
        with contextlib.suppress(OSError):
            self._filler.write_bytes(bytes(max(0, shutil.disk_usage(self.folder).free - left)))

    def forbid(self) -> None:
        """Make it read-only; no file may be open."""
        if self.mounted:
            self._mount_again("ro")
        else:
            self.take_rights()

    def take_rights(self) -> None:
        """Let nobody write into the folders any more; files that are open stay so."""
        self._set_rights(0o555)
        if os.geteuid() == 0:  # rights do not bind the superuser
            os.seteuid(NOBODY)

    def mend(self) -> None:
        """Room and rights again."""
        os.seteuid(os.getuid())
        if self.mounted:
            self._mount_again("rw")
        _limit_files(resource.getrlimit(resource.RLIMIT_FSIZE)[1])
        self._set_rights(0o777)
        self._filler.unlink(missing_ok=True)

    def _mount_again(self, how: str) -> None:
        subprocess.run(["mount", "-o", f"remount,{how}", self.folder], check=True)

    def _set_rights(self, mode: int) -> None:
        for folder in (self.folder, *(each for each in self.folder.rglob("*") if each.is_dir())):
            folder.chmod(mode)


def _limit_files(size: int) -> None:
    """Let no file of this process grow beyond a size [bytes]."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
