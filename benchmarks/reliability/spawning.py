"""A process with one thread, which may fork; it tells of its tries line by line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

Order = dict[str, Any]

_PROGRAM = "import sys; sys.path[:0] = {path!r}; from reliability import {module}; {call}"


def served(module: str, order: Order, before: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """What `serve(order)` of a module of this package yields, in a process of its own.

    Args:
        module: its name.
        order: plain data.
        before: words of a command line that are to start the process, as those of `unshare`.

    Raises:
        RuntimeError: when the process fails.
    """
    path = [str(Path(__file__).parents[1]), *sys.path]
    call = f"from reliability import spawning; spawning.tell({module}.serve({order!r}))"
    process = subprocess.Popen(
        [*before, sys.executable, "-c", _PROGRAM.format(path=path, module=module, call=call)],
        stdout=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    assert process.stdout is not None
    with process:
        try:
            for line in process.stdout:
                yield json.loads(line)
        except GeneratorExit:
            process.kill()
            raise
    if process.returncode != 0:
        raise RuntimeError(f"{module}: the process of the tries ended with {process.returncode}")


def tell(results: Iterator[dict[str, Any]]) -> None:
    """Print results as lines."""
    for result in results:
        print(json.dumps(result), flush=True)


class Child:
    """A forked process that tells bytes until it is killed."""

    def __init__(self, work: Callable[[Callable[[bytes], None]], None]) -> None:
        """Begin.

        Args:
            work: is given what tells bytes.
        """
        self._reading, writing = os.pipe()
        sys.stdout.flush()
        self._process = os.fork()
        if self._process == 0:
            status = 1
            try:
                work(lambda data: void(os.write(writing, data)))
                status = 0
            except BaseException as error:  # noqa: BLE001 - told below, in the parent
                os.write(writing, b"!" + repr(error).encode()[:1000])
            finally:
                os._exit(status)
        os.close(writing)
        os.set_blocking(self._reading, False)
        self._told = b""

    def told(self) -> bytes:
        """What it has told by now.

        Raises:
            RuntimeError: it failed before it was killed.
        """
        while True:
            try:
                data = os.read(self._reading, 65536)
            except BlockingIOError:
                break
            if not data:
                break
            self._told += data
        if b"!" in self._told:
            raise RuntimeError(self._told[self._told.index(b"!") :].decode())
        return self._told

    def kill(self) -> bytes:
        """Kill it; all that it has told."""
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        told = self.told()
        os.close(self._reading)
        return told


def void(_: object) -> None:
    """Nothing."""


def wait_until(moment: float) -> None:
    """Sleep until a moment of the monotonic clock [s]."""
    time.sleep(max(0.0, moment - time.monotonic()))
