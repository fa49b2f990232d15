"""Handing sets to the diagnosis: each once, in processes that cannot read the answers."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import queue
import select
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from blind.layout import Round
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write

WORKER = Path(__file__).with_name("worker.py")
ALWAYS = ("--no-simulation", "--jobs", "1")
"""Of every diagnosis: what is scored needs no replay, and each process has one set at a time."""
PATIENCE_S = 900.0
"""A diagnosis that takes longer has failed."""


@dataclass(frozen=True)
class Submission:
    """One set for one diagnosis.

    Attributes:
        number: of the set.
        session: to diagnose.
        variant: what is switched off, or empty.
        options: of `shoecal diagnose` for it.
    """

    number: int
    session: Path
    variant: str = ""
    options: tuple[str, ...] = ()

    @property
    def entry(self) -> str:
        """Its line in the ledger begins so."""
        return f"{self.number} {self.variant or 'whole'}"


class Ledger:
    """Which submissions have been answered; none is taken twice."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def entries(self) -> set[str]:
        """Submissions so far."""
        if not self._path.is_file():
            return set()
        return {line.rsplit(" ", 1)[0] for line in self._path.read_text().splitlines()}

    def enter(self, submission: Submission, result: bytes) -> None:
        """Write an answer down.

        Raises:
            ShoecalError: for a second one.
        """
        with self._path.open("a") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            if submission.entry in self.entries():
                raise ShoecalError(
                    f"set {submission.number} has been submitted in this round; make a new round"
                )
            file.write(f"{submission.entry} {hashlib.sha256(result).hexdigest()}\n")
            file.flush()
            os.fsync(file.fileno())


def submit(place: Round, submissions: Sequence[Submission], jobs: int) -> None:
    """Diagnose what is not in the ledger yet."""
    ledger = Ledger(place.ledger)
    known = ledger.entries()
    todo: queue.SimpleQueue[Submission] = queue.SimpleQueue()
    missing = [one for one in submissions if one.entry not in known]
    for one in missing:
        todo.put(one)
    done = _Count(len(missing))
    threads = [
        threading.Thread(target=_serve, args=(place, ledger, todo, done.told))
        for _ in range(min(jobs, len(missing)))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if done.error is not None:
        raise done.error


@dataclass
class _Count:
    """What is done of all, and the first error of a thread."""

    total: int
    done: int = 0
    error: ShoecalError | None = None
    lock: threading.Lock = field(default_factory=threading.Lock)

    def told(self, what: str, error: ShoecalError | None = None) -> None:
        with self.lock:
            self.done += 1
            self.error = self.error or error
            print(f"diagnosed {self.done} of {self.total}: {what}", flush=True)


def _serve(
    place: Round,
    ledger: Ledger,
    todo: queue.SimpleQueue[Submission],
    told: Callable[[str, ShoecalError | None], None],
) -> None:
    worker = _Worker(place)
    try:
        while True:
            try:
                one = todo.get_nowait()
            except queue.Empty:
                return
            begin = time.monotonic()
            result = worker.diagnose(one)
            file = place.diagnosis(one.number, one.variant)
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                ledger.enter(one, result)
                atomic_write(file, result)
            except ShoecalError as error:
                told(one.entry, error)
                return
            told(f"{one.entry}, {time.monotonic() - begin:.0f} s", None)
    finally:
        worker.end()


class _Worker:
    """A process that diagnoses; a new one where it broke."""

    def __init__(self, place: Round) -> None:
        self._place = place
        self._process: subprocess.Popen[str] | None = None
        self._drop = place.folder / "drop" / f"{threading.get_ident():x}"
        self._drop.mkdir(parents=True, exist_ok=True)

    def diagnose(self, one: Submission) -> bytes:
        """What the diagnosis says, or an error, as JSON."""
        answer = self._drop / "answer.json"
        answer.unlink(missing_ok=True)
        command = ["diagnose", str(one.session), "--json", str(answer), *ALWAYS, *one.options]
        said = self._ask(json.dumps(command))
        if said is None:
            return json.dumps({"error": "the process ended or took too long"}).encode()
        if said["code"] != 0 or not answer.is_file():
            return json.dumps({"error": said["error"]}).encode()
        return answer.read_bytes()

    def end(self) -> None:
        """Let the process end."""
        if self._process is not None:
            assert self._process.stdin is not None
            self._process.stdin.close()
            self._process.wait()
            self._process = None

    def _ask(self, line: str) -> dict[str, object] | None:
        process = self._process = self._process or self._start()
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(line + "\n")
            process.stdin.flush()
            if select.select([process.stdout], [], [], PATIENCE_S)[0]:
                told = process.stdout.readline()
                if told:
                    said: dict[str, object] = json.loads(told)
                    return said
        except BrokenPipeError:
            pass
        process.kill()
        process.wait()
        self._process = None
        return None

    def _start(self) -> subprocess.Popen[str]:
        """A Python that does not see our folder, without the powers of root."""
        cache = str(self._drop)
        kept = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
        alone = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        return subprocess.Popen(
            [*powerless(), sys.executable, "-P", str(WORKER), str(self._place.sealed)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=self._drop,
            env=kept | alone | {"HOME": cache, "XDG_CACHE_HOME": cache, "MPLCONFIGDIR": cache},
        )


def powerless() -> tuple[str, ...]:
    """Starts a program without what makes root root: it then reads only what root owns."""
    setpriv = shutil.which("setpriv")
    if os.geteuid() != 0 or setpriv is None:
        return ()
    return (setpriv, "--bounding-set=-all", "--inh-caps=-all")
