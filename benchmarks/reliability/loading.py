"""Loading files that were tampered with, in a process of its own whose memory and time are bound.

A module of mutants has a function `target(folder)`. What its mutants come to is judged here: a
mutant is refused with one line that names its file and a code that belongs to files of its kind,
or loaded as it stands. Whatever else happens is a failure: another exception, too much memory asked
for, too much time, code that runs, a file outside the folder that is opened, a child or a
connection.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import select
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any, Protocol, TextIO

import numpy as np

from reliability.row import Progress, Result
from shoecal_core.errors import ShoecalError, error_code

MEMORY = 2 * 2**30
"""Bytes of address space that a process of mutants may have."""
SECONDS = 10.0
"""Of the processor's time for one load."""
_SILENCE_S = 300.0
"""Nobody waits longer for a load that waits itself, for a pipe for example; a busy machine does."""
_END_S = 5.0
_START_S = 600.0
"""A busy machine takes its time to start a process."""
_LONGEST_MESSAGE = 2100

_NEVER = {
    "ctypes.dlopen", "os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.system",
    "pickle.find_class", "socket.connect", "socket.getaddrinfo", "subprocess.Popen",
    "urllib.Request",
}  # fmt: skip
"""Events of the interpreter that no file may cause."""

_WORKER = """\
import sys
sys.path[:0] = {path!r}
from reliability import loading, {module}
loading.work({module}.target, {order!r})
"""


class WrongLoadError(Exception):
    """A mutant that was loaded, but not as it stands."""


class Target(Protocol):
    """Files of one kind, whole at first.

    Attributes:
        codes: one of them tells a program why a mutant is refused.
    """

    codes: frozenset[str]

    def load(self) -> None:
        """Load what is there.

        Raises:
            ShoecalError: it is refused.
            WrongLoadError: it is loaded wrongly.
        """

    def mutate(self, rng: np.random.Generator) -> str:
        """Lay a mutant there instead of what was there before; what was done to it."""


@dataclass(frozen=True)
class Try:
    """What one mutant came to.

    Attributes:
        index: its number.
        what: was done to the file.
        refused: the message; empty where it was loaded.
        code: of the refusal.
        failed: what must not have happened; empty where all is well.
        seconds: the load took, of the processor's time.
        mebibytes: the most that the process held meanwhile.
    """

    index: int
    what: str
    refused: str = ""
    code: str = ""
    failed: str = ""
    seconds: float = 0.0
    mebibytes: float = 0.0


def try_mutants(module: str, first: int, count: int, seed: int, progress: Progress) -> Result:
    """What a row of mutants comes to.

    Args:
        module: of this package; it has a function `target`.
        first, count: which mutants.
        seed: they are drawn from it and their number.
        progress: is told how many are done.
    """
    failed, worst, figure, most, refused = 0, "", 0.0, 0.0, 0
    for done, one in enumerate(tries(module, first, count, seed), start=1):
        if one.failed and not failed:
            worst = f"mutant {one.index} ({one.what}): {one.failed}"
        failed += bool(one.failed)
        refused += bool(one.refused)
        figure, most = max(figure, one.seconds), max(most, one.mebibytes)
        progress(done)
    if not failed:
        worst = f"{figure:.2f} s, {most:.0f} MiB"
    return Result(count, failed, worst, figure, {"refused": refused})


def tries(module: str, first: int, count: int, seed: int) -> Iterator[Try]:
    """Every mutant, one after the other; a process that dies is followed by another."""
    at, last = first, first + count
    while at < last:
        begun = at
        # What one process leaves behind is nothing for the next.
        with (
            tempfile.TemporaryDirectory(prefix="shoecal-mutants-") as folder,
            tempfile.TemporaryFile() as errors,
        ):
            order = {"first": at, "last": last, "seed": seed, "folder": folder}
            for one in _watched(module, order, errors):
                yield one
                at = one.index + 1
        if at == begun:
            raise RuntimeError(f"{module}: the process of the mutants tried none")


def _watched(module: str, order: dict[str, Any], errors: IO[bytes]) -> Iterator[Try]:
    """Mutants of one process, to the one that it dies of.

    Args:
        module: of the row.
        order: what it is to try.
        errors: file of its standard error: a pipe that nobody empties may stop it.
    """
    paths = [str(Path(__file__).parents[1]), *sys.path]
    process = subprocess.Popen(
        [sys.executable, "-c", _WORKER.format(path=paths, module=module, order=order)],
        stdout=subprocess.PIPE,
        stderr=errors,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    assert process.stdout is not None
    begun: Try | None = None
    with process:
        try:
            for line in _lines(process.stdout.fileno()):
                found = Try(**line["try"])
                if line["done"]:
                    begun = None
                    yield found
                else:
                    begun = found
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(_END_S)  # how it ended by itself
        finally:
            process.kill()
        status = process.wait()
        errors.seek(0)
        told = errors.read()
    if begun is not None:
        yield Try(begun.index, begun.what, failed=f"the process died of it: {_death(status)}")
    elif status not in (0, -signal.SIGKILL):
        raise RuntimeError(f"mutants cannot be tried: {told.decode(errors='replace')[-2000:]}")


def _lines(stream: int) -> Iterator[dict[str, Any]]:
    """Lines of a process until it ends, or says nothing for too long."""
    rest, patience_s = b"", _START_S
    while select.select([stream], [], [], patience_s)[0]:
        patience_s = _SILENCE_S
        data = os.read(stream, 65536)
        if not data:
            return
        *complete, rest = (rest + data).split(b"\n")
        yield from map(json.loads, complete)


def _death(status: int) -> str:
    if status == -signal.SIGPROF:
        return f"more than {SECONDS:g} s"
    if status == -signal.SIGKILL:
        return f"it waited for more than {_SILENCE_S:g} s"
    return signal.Signals(-status).name if status < 0 else f"exit code {status}"


# In the process of the mutants


def work(make: Callable[[Path], Target], order: dict[str, Any]) -> None:
    """Try the mutants of an order, of a target that is made here; tell of each before and after."""
    lines = os.fdopen(os.dup(1), "w")
    # Parsers tell their trouble on both; nobody reads it.
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    folder = Path(order["folder"])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    target = make(folder)
    target.load()
    # What Python says of an exception here is still told; nobody empties the rest.
    sys.stderr = os.fdopen(os.dup(2), "w")
    warnings.simplefilter("ignore")
    os.dup2(silent, 2)
    watch = _Watch(folder)
    for index in range(order["first"], order["last"]):
        # Mutants that unfold into gigabytes take some to make.
        _allow(resource.RLIM_INFINITY)
        what = target.mutate(np.random.default_rng([order["seed"], index]))
        _allow(MEMORY)
        _tell(lines, Try(index, what), done=False)
        _tell(lines, _judge(target, watch, index, what), done=True)


def _allow(memory: int) -> None:
    """So much memory from now on; what was held at most is forgotten."""
    resource.setrlimit(resource.RLIMIT_AS, (memory, resource.RLIM_INFINITY))
    Path("/proc/self/clear_refs").write_text("5")


def _held_mebibytes() -> float:
    """The most that this process has held since it was last allowed memory."""
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def _tell(lines: TextIO, one: Try, *, done: bool) -> None:
    print(json.dumps({"done": done, "try": asdict(one)}), file=lines, flush=True)


def _judge(target: Target, watch: _Watch, index: int, what: str) -> Try:
    refused, code, failed = "", "", ""
    watch.begin()
    begun = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        target.load()
    except ShoecalError as error:
        refused, code = str(error), error_code(type(error))
        failed = _wrong_message(error, watch.folder)
        if code not in target.codes:
            failed = failed or f"refused with the code {code}, of no such file: {refused[:200]}"
    except WrongLoadError as error:
        failed = f"loaded wrongly: {error}"
    except BaseException as error:  # noqa: BLE001 - whatever comes is what is looked for
        failed = f"{type(error).__name__}: {error}"[:300]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    seconds = time.process_time() - begun
    held = round(_held_mebibytes(), 1)
    return Try(index, what, refused, code, failed or watch.seen(), round(seconds, 4), held)


def _wrong_message(error: ShoecalError, folder: Path) -> str:
    """What is wrong with a refusal; empty where nothing is."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, MemoryError):
            return "refused only after more memory was asked for than there is"
        cause = cause.__cause__ or cause.__context__
    message = str(error)
    if "\n" in message or len(message) > _LONGEST_MESSAGE:
        return f"a message of {len(message)} letters: {message[:100]}"
    if str(folder) not in message:
        return f"the message does not name the file: {message[:200]}"
    return ""


class _Watch:
    """Sees what a load does beside reading its own files.

    Attributes:
        folder: of the files, and of a file `canary` that must never appear.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._canary = folder / "canary"
        self._seen: list[str] = []
        self._ours = (str(folder), sys.prefix, sys.base_prefix, "/proc/self", str(_root()))
        sys.addaudithook(self._audit)

    def begin(self) -> None:
        self._seen.clear()

    def seen(self) -> str:
        """What must not have been; empty where nothing was."""
        if self._canary.exists():
            self._canary.unlink()
            self._seen.append("code of the file ran")
        return "; ".join(self._seen)[:300]

    def _audit(self, event: str, arguments: tuple[object, ...]) -> None:
        if event in _NEVER:
            self._seen.append(f"{event}{arguments}")
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path = os.fsdecode(arguments[0])
            if Path(path).is_absolute() and not path.startswith(self._ours):
                self._seen.append(f"opens {path}")


def _root() -> Path:
    """The checkout: modules are loaded from there when first used."""
    return Path(__file__).parents[2]


PLAIN = frozenset({"file-missing", "file-unreadable", "file-too-large", "file-syntax"})
"""Codes of files of every kind, by what the system and the parser say of them."""


def make_trap(folder: Path) -> Path:
    """A pipe that nobody writes to: who opens it for reading waits for ever."""
    trap = folder / "trap"
    with contextlib.suppress(FileExistsError):
        os.mkfifo(trap)
    return trap
