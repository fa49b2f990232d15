"""A forked process that does a job until it is killed."""

from __future__ import annotations

import ctypes
import multiprocessing
import signal
import time
from collections.abc import Callable
from multiprocessing.sharedctypes import RawValue

from reliability.tries import BrokenError

Steps = ctypes.c_int64
"""Counted up by a child's job, read by whoever kills it."""
PATIENCE_S = 60.0


class Child:
    """A forked process that does a job until it is killed."""

    def __init__(self, job: Callable[[Steps], None]) -> None:
        """Begin.

        Args:
            job: counts up, in the value that it is given, the steps that are done.
        """
        self._steps = RawValue(Steps, 0)
        fork = multiprocessing.get_context("fork")
        self._process = fork.Process(target=job, args=(self._steps,), daemon=True)
        self._process.start()

    def wait(self, steps: int) -> None:
        """Wait until so many steps are done, or a minute is over."""
        until = time.monotonic() + PATIENCE_S
        while self._steps.value < steps and time.monotonic() < until:
            time.sleep(0.0005)

    def kill(self) -> int:
        """Kill it with SIGKILL; how many steps it has done.

        Raises:
            BrokenError: when it had ended before.
        """
        self._process.kill()
        self._process.join()
        if self._process.exitcode != -signal.SIGKILL:
            raise BrokenError(f"its process ended with {self._process.exitcode}")
        return self._steps.value
