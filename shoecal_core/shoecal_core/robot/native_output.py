"""What C++ libraries print by themselves, kept away from the terminal."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

STDERR = 2
"""C++ writes to the descriptor itself, past Python's `sys.stderr`."""


@contextmanager
def caught_stderr() -> Iterator[list[str]]:
    """Catch what the whole process writes to stderr meanwhile; afterwards it is as before.

    For a moment only, around a parser whose complaints are reported in one line of our own.

    Yields:
        the lines; they stand there once the block has been left.
    """
    lines: list[str] = []
    try:
        kept = os.dup(STDERR)
    except OSError:
        # A process without stderr has nothing to keep quiet.
        yield lines
        return
    with os.fdopen(os.memfd_create("stderr"), "w+b") as file:
        os.dup2(file.fileno(), STDERR)
        try:
            yield lines
        finally:
            os.dup2(kept, STDERR)
            os.close(kept)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()
