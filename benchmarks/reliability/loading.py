"""Loading mutants of files in their own process, with bounded memory and processor time.

A mutant must be refused with one line that names its file and with a code of its kind of file, or
load as it says. All else is a failure: another exception, too much memory or time, code that runs,
a file outside the folder that is opened, a child process or a connection.

`lay(folder)(np.random.default_rng([seed, index]))` makes one mutant again.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from reliability.row import Progress, Result
from shoecal_core.errors import ShoecalError, error_code

Load = Callable[[], object]
"""Loads a mutant; raises ShoecalError when it is refused, WrongLoadError when loaded wrongly."""
Draw = Callable[[np.random.Generator], Load]
"""Lays a mutant in place of the one before."""
Lay = Callable[[Path], Draw]
"""Lays whole files into a folder, loads them, and returns what makes mutants of them."""

MEMORY = 2 * 2**30
"""Bytes of address space that a load may take."""
SECONDS = 10.0
"""Of the processor's time that a load may take."""
SILENCE_S = 300.0
"""A load that takes longer waits for something, for example for a pipe."""
_START_S = 600.0
"""A busy machine takes its time to start a process."""
_LONGEST_MESSAGE = 2100

_NEVER = {
    "ctypes.dlopen", "os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.system",
    "pickle.find_class", "socket.connect", "socket.getaddrinfo", "subprocess.Popen",
    "urllib.Request",
}  # fmt: skip
"""Audit events of Python that no file may cause."""


class WrongLoadError(Exception):
    """A mutant that was loaded, but not as it says."""


class Try(NamedTuple):
    """Result of one mutant: what failed (empty: nothing), and the load's processor time [s]."""

    failed: str
    refused: bool = False
    seconds: float = 0.0


def try_mutants(
    lay: Lay, codes: frozenset[str], first: int, count: int, seed: int, progress: Progress
) -> Result:
    """Try some mutants: the `run` of a row.

    Args:
        lay: makes the files of one kind.
        codes: with which such a file may be refused.
        first: number of the first mutant.
        count: how many.
        seed: from which, with its number, a mutant is drawn.
        progress: called with the number of finished ones.
    """
    tries: list[Try] = []
    for one in _tries(lay, codes, range(first, first + count), seed):
        tries.append(one)
        progress(len(tries))
    slowest = max(one.seconds for one in tries)
    failures = [f"mutant {first + at}: {one.failed}" for at, one in enumerate(tries) if one.failed]
    worst = failures[0] if failures else f"{slowest:.2f} s"
    refused = sum(one.refused for one in tries)
    return Result(count, len(failures), worst, slowest, {"refused": refused})


def _tries(lay: Lay, codes: frozenset[str], numbers: range, seed: int) -> Iterator[Try]:
    """Try every mutant; a process that dies of one is followed by another."""
    context = multiprocessing.get_context("spawn")
    while numbers:
        receiver, sender = context.Pipe(duplex=False)
        with tempfile.TemporaryDirectory(prefix="shoecal-mutants-") as folder, receiver:
            process = context.Process(
                target=work, args=(sender, lay, codes, Path(folder), numbers, seed)
            )
            process.start()
            sender.close()
            patience_s = _START_S
            try:
                while receiver.poll(patience_s):
                    if (one := receiver.recv()) is not None:
                        yield one
                        numbers = numbers[1:]
                    patience_s = SILENCE_S
            except EOFError:  # it has ended, well or not
                process.join(SILENCE_S)
            finally:
                process.kill()
                process.join()
        if patience_s == _START_S:
            raise RuntimeError(f"the whole files cannot be loaded: exit code {process.exitcode}")
        if numbers:
            yield Try(f"its process died: {_death(process.exitcode)}")
            numbers = numbers[1:]


def _death(status: int | None) -> str:
    if status == -signal.SIGPROF:
        return f"more than {SECONDS:g} s of the processor"
    if status == -signal.SIGKILL:
        return f"it waited for more than {SILENCE_S:g} s"
    return f"exit code {status}"


# In the process of the mutants


def work(
    sender: Connection,
    lay: Lay,
    codes: frozenset[str],
    folder: Path,
    numbers: range,
    seed: int,
) -> None:
    """Try mutants and send a `Try` of each; None before the first, when whole files have loaded."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.mkfifo(folder / "trap")  # mutants name this pipe; opening it waits for ever
    draw = lay(folder)
    watch = Watch(folder)
    sender.send(None)
    # Parsers write to both streams; tracebacks of this process are still printed.
    sys.stderr = os.fdopen(os.dup(2), "w")
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    warnings.simplefilter("ignore")
    for index in numbers:
        load = draw(np.random.default_rng([seed, index]))
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
        found = judge(load, codes, watch)
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        sender.send(found)


def judge(load: Load, codes: frozenset[str], watch: Watch) -> Try:
    """Load a mutant; the process is killed by SIGPROF when that takes too long."""
    refused, failed = False, ""
    watch.events.clear()
    begun = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        load()
    except ShoecalError as error:
        refused, failed = True, _wrong_refusal(error, codes, watch.folder)
    except WrongLoadError as error:
        failed = f"loaded wrongly: {error}"
    except BaseException as error:  # noqa: BLE001 - any other exception is a failure
        failed = f"{type(error).__name__}: {error}"[:300]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    seconds = time.process_time() - begun
    if watch.canary.exists():
        watch.canary.unlink()
        watch.events.append("code of the file ran")
    return Try(failed or "; ".join(watch.events)[:300], refused, seconds)


def _wrong_refusal(error: ShoecalError, codes: frozenset[str], folder: Path) -> str:
    """What is wrong with a refusal; empty where nothing is."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, MemoryError):
            return "refused only after more memory was asked for than there is"
        cause = cause.__cause__ or cause.__context__
    message, code = str(error), error_code(type(error))
    if "\n" in message or len(message) > _LONGEST_MESSAGE:
        return f"a message of {len(message)} letters: {message[:100]}"
    if str(folder) not in message:
        return f"the message does not name the file: {message[:200]}"
    return "" if code in codes else f"refused with the code {code}: {message[:200]}"


class Watch:
    """Notes what a load must not do.

    Attributes:
        folder: of the files.
        canary: file that appears when code of a mutant runs.
        events: what was noted, in words.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.canary = folder, folder / "canary"
        self.events: list[str] = []
        checkout = Path(__file__).parents[2]  # modules are loaded from there when first used
        ours = (folder, sys.prefix, sys.base_prefix, "/proc/self", checkout)
        self._ours = tuple(map(str, ours))
        sys.addaudithook(self._audit)

    def _audit(self, event: str, arguments: tuple[object, ...]) -> None:
        if event in _NEVER:
            self.events.append(f"{event}{arguments}")
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path = os.fsdecode(arguments[0])
            if Path(path).is_absolute() and not path.startswith(self._ours):
                self.events.append(f"opens {path}")
