"""A disk that is full, read-only or broken, before and while a run is recorded.

The disk is a small tmpfs in a mount namespace of its own, filled up or mounted read-only; a folder
whose rights are taken away during a recording stands for a disk that becomes read-only. A broken
one refuses a drawn fsync or rename, or all from then on (the calls of the operating system are made
to fail), while a calibration is applied and a run recorded; that change may come about, then it is
in force for good. Where nothing may be mounted, the size of files is limited instead
(RLIMIT_FSIZE), and the worst try says so.

A session, a run, a log of raw bytes and a calibration are to be written there; in the read-only
tries there is also what is left of a change of the calibration that was cut. Each is refused with
one line that names the file and the code of its trouble, no room or not to be written, at once or
when it is written; what was recorded before is recovered; the calibration in force is the same as
before, for this process and for the next; and with room again, all of it works.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import shutil
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from reliability import originals
from reliability.broken_disk import BrokenDisk
from reliability.recovered import recovered_samples
from reliability.row import Progress, Result, Row
from reliability.small_disk import SmallDisk, hide_mounts
from reliability.tries import BrokenError, run_tries
from shoecal_core.errors import FileError, ShoecalError, error_code
from shoecal_core.estimation.calibration import save_calibration
from shoecal_ros.calibrator.calibration_store import NEXT, CalibrationStore
from shoecal_ros.common.codes import Code
from shoecal_ros.serial.raw_log import RawLog

KINDS = ("full before", "full during", "read-only before", "read-only during", "broken")
FULL, UNWRITABLE = "disk-full", "file-unwritable"
"""Codes of what is refused."""
MOST_CALLS = 14
"""Of fsync or replace while a calibration is applied, and some more."""
TOO_MANY = 20_000
"""Samples that no disk here has room for."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """One disk a try, all in a process of their own, whose mounts nobody else sees."""
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawn, initializer=hide_mounts) as process:
        result = process.submit(tries, first, count, seed).result()
    progress(count)
    return result


def tries(first: int, count: int, seed: int) -> Result:
    """Fill disks up, make them read-only or break them."""
    mounted = True

    def attempt(number: int, rng: np.random.Generator) -> None:
        nonlocal mounted
        kind = KINDS[number % len(KINDS)]
        with (
            tempfile.TemporaryDirectory(prefix="shoecal-disk-") as name,
            SmallDisk(Path(name)) as disk,
        ):
            mounted &= disk.mounted
            try:
                _Try(disk).run(kind, rng)
            except (BrokenError, ShoecalError, OSError) as error:
                raise BrokenError(f"{kind}: {error}") from error

    result = run_tries(attempt, first, count, seed, lambda _: None)
    how = "on a tmpfs" if mounted else "with RLIMIT_FSIZE, as nothing may be mounted here"
    return replace(result, worst=result.worst or f"each told in one line, {how}")


class _Try:
    """A session, and a store with one calibration in force, on a disk."""

    def __init__(self, disk: SmallDisk) -> None:
        self._disk = disk
        self._session = originals.session(disk.folder / "session")
        self._store = self._next_store()
        self._apply("one")

    def run(self, kind: str, rng: np.random.Generator) -> None:
        """Write while the disk refuses it, and check what is left."""
        in_force = ["one", None]
        if kind.startswith("read-only"):
            # A change was cut before: what is left of it cannot be removed.
            save_calibration(originals.calibration("left"), self._disk.folder / "state" / NEXT)
        if kind == "broken":
            in_force = self._write_broken(rng)
        elif kind.endswith("before"):
            self._write_before(FULL if kind.startswith("full") else UNWRITABLE)
        else:
            self._write_during(FULL if kind.startswith("full") else UNWRITABLE, rng)
        self._check_in_force(in_force)
        self._disk.mend()
        shutil.rmtree(self._disk.folder / "other", ignore_errors=True)
        self._record(20)
        self._apply("two")
        left = [path.name for path in (self._disk.folder / "state").glob(".*")]
        if left:
            raise BrokenError(f"left behind: {', '.join(left)}")

    def _write_before(self, code: str) -> None:
        """On a disk that is full or read-only already."""
        self._disk.fill(0) if code == FULL else self._disk.forbid()
        for write in (
            lambda: self._record(TOO_MANY),
            lambda: originals.session(self._disk.folder / "other"),
            lambda: self._apply("two"),
        ):
            self._must_refuse(code, write)

    def _write_during(self, code: str, rng: np.random.Generator) -> None:
        """On one that becomes so during a run; then the run is recovered."""
        if code == FULL:
            self._disk.fill(int(rng.integers(4096, 200_000)))
            self._must_refuse(code, lambda: self._record(TOO_MANY))
        else:
            self._must_refuse(code, lambda: self._record(50, self._disk.take_rights))
        self._disk.mend()
        recovered_samples(self._session)
        self._disk.fill(0)
        self._log_bytes()

    def _write_broken(self, rng: np.random.Generator) -> list[str | None]:
        """On one that refuses some calls; ids of what is in force then, and of the one before."""
        call = ("fsync", "replace")[rng.integers(2)]
        with BrokenDisk(call, int(rng.integers(1, MOST_CALLS)), lasting=bool(rng.integers(2))):
            refused = self._refuses(UNWRITABLE, lambda: self._apply("two"))
            self._refuses(UNWRITABLE, lambda: self._record(20))
        return ["one", None] if refused else ["two", "one"]

    def _apply(self, identity: str) -> None:
        self._store.apply(originals.calibration(identity), originals.START_NS)

    def _record(self, samples: int, last: Callable[[], None] = lambda: None) -> None:
        """Record a run; do something before it is finished."""
        writer = self._session.new_run("landmarks", originals.SUPPORT)
        try:
            for index in range(samples):
                for topic, data in originals.sample(index).items():
                    writer.write(topic, data, originals.START_NS + index * originals.STEP_NS)
            last()
            writer.close()
        except ShoecalError:
            with contextlib.suppress(ShoecalError):
                writer.abandon()
            raise

    def _log_bytes(self) -> None:
        """Have a log of raw bytes end, or not begin, on a full disk."""
        try:
            log = RawLog(self._disk.folder / "raw.log")
        except FileError as error:
            self._check(error, FULL)
            return
        log.write(bytes(2**21))
        log.close()
        if log.problem is None or log.problem.code != Code.RAW_LOG_ENDED:
            raise BrokenError("a log of raw bytes does not tell that it has ended")

    def _refuses(self, code: str, write: Callable[[], object]) -> bool:
        """Whether something is refused, with this code and a line that names a file."""
        try:
            write()
        except ShoecalError as error:
            self._check(error, code)
            return True
        return False

    def _must_refuse(self, code: str, write: Callable[[], object]) -> None:
        if not self._refuses(code, write):
            raise BrokenError("nothing was refused")

    def _check(self, error: ShoecalError, code: str) -> None:
        if error_code(type(error)) != code:
            raise BrokenError(f"the code is {error_code(type(error))}, not {code}: {error}")
        if str(self._disk.folder) not in str(error) or "\n" in str(error):
            raise BrokenError(f"no line that names a file: {error}")

    def _check_in_force(self, wanted: list[str | None]) -> None:
        """This process and the next have these calibrations in force and before."""
        again = self._next_store()
        again.load(originals.START_NS)
        for store in (self._store, again):
            found = [one and one.id for one in (store.current, store.before)]
            if found != wanted:
                raise BrokenError(f"in force and before are {found}, not {wanted}")

    def _next_store(self) -> CalibrationStore:
        """As another process has it."""
        folder = self._disk.folder / "state"
        return CalibrationStore(folder, originals.robot(), originals.shoe())


ROW = Row(
    key="full-disk",
    fault="disk full, read-only or broken, before and during a recording",
    holds="refused before, or a clean failure, each with its code; what was recorded recovers; the "
    "calibration in force stays",
    tries=200,
    step=40,
    run=run,
)
