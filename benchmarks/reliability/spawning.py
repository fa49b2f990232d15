"""Processes for tries that fork: one with a single thread, and children of it that are killed."""

from __future__ import annotations

import ctypes
import importlib
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from multiprocessing.sharedctypes import RawValue
from pathlib import Path

from reliability.row import Progress, Result
from reliability.tries import BrokenError

Steps = ctypes.c_int64
"""Counted up by a child's job, read by whoever kills it."""
PATIENCE_S = 60.0


def run_apart(
    module: str, first: int, count: int, seed: int, progress: Progress, before: Sequence[str] = ()
) -> Result:
    """What `tries(first, count, seed, progress)` of a module gives in a process of its own.

    Args:
        module: of this package.
        first: number of the first try.
        count: how many.
        seed: of all draws.
        progress: is told how many are done.
        before: words of a command line that start the process, as those of `unshare`.

    Raises:
        RuntimeError: when the process fails.
    """
    command = [*before, sys.executable, "-m", __name__, module, str(first), str(count), str(seed)]
    path = os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])
    environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
    told: object = None
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        for line in process.stdout:
            told = json.loads(line)
            if isinstance(told, int):
                progress(told)
    if process.returncode or not isinstance(told, dict):
        raise RuntimeError(f"{module}: the process of the tries ended with {process.returncode}")
    return Result(**told)


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


def wait_until(moment: float) -> None:
    """Sleep until a moment of the monotonic clock [s]."""
    time.sleep(max(0.0, moment - time.monotonic()))


def main() -> None:
    """Do the tries of a module; print how many are done, then the result."""
    module, *numbers = sys.argv[1:]
    tries = importlib.import_module(f"reliability.{module}").tries
    result = tries(*map(int, numbers), lambda done: print(done, flush=True))
    print(json.dumps(asdict(result)))


if __name__ == "__main__":
    main()
