"""Programs that end with the process that started them, even where that one was killed.

Run by itself, this file is how such a program starts: it asks for a signal at its parent's end, and
then becomes the program. That needs nothing between fork and exec, where threads forbid nearly all.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Sequence

_PR_SET_PDEATHSIG = 1


def ending_with_parent(command: Sequence[str]) -> list[str]:
    """A command for the same program, which gets SIGTERM as soon as its parent ends.

    To the kernel the parent is the thread that starts it, not that thread's process: it has to be
    one that lives as long as the program shall.
    """
    return [sys.executable, "-I", "-S", __file__, str(os.getpid()), *command]


def _become(command: list[str], parent: int) -> None:
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        sys.exit("not started: the process that asked for it has ended")
    # Python ignores these, and what is ignored stays so.
    for number in (signal.SIGPIPE, signal.SIGXFSZ):
        signal.signal(number, signal.SIG_DFL)
    # The command comes from the parent.
    os.execvp(command[0], command)  # noqa: S606


if __name__ == "__main__":
    _become(sys.argv[2:], int(sys.argv[1]))
