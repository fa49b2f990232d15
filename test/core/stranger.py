"""A process that another one has started: no child of this one, so that nobody waits for it."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from types import TracebackType
from typing import Self

TIMEOUT_S = 60.0


class Stranger:
    """Is known while its context is open, whoever may get its number afterwards."""

    def __init__(self, pid: int) -> None:
        """Of a process that runs."""
        self._descriptor = os.pidfd_open(pid)

    def ends(self) -> bool:
        """Wait until it ends; whether it did."""
        readable, _, _ = select.select([self._descriptor], [], [], TIMEOUT_S)
        return bool(readable)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._descriptor, signal.SIGKILL)
        os.close(self._descriptor)
