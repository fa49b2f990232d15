"""A disk that is full, read-only or broken, before and while a run is recorded.

The disk is a small tmpfs of its own, in a mount namespace that nobody else sees (`unshare`), filled
up or mounted read-only; a folder whose rights are taken away during a recording stands for the one
that becomes read-only. A broken one refuses a drawn fsync or rename, or all from then on (the calls
of the operating system are made to fail), while a calibration is applied and a run recorded; that
change may come about, then it is in force for good. Where nothing may be mounted, the size of files
is limited instead (RLIMIT_FSIZE), and the worst try says so. A session, a run, a log of raw bytes
and a calibration are to be written there; in the read-only tries there lies also what is left of a
change of the calibration that was cut. Each is refused with one line that names the file and the
code of its trouble, no room or not to be written, at once or when it is written; what was recorded
before is recovered; the calibration in force is the same as before, for this process and for the
next; and with room again, all of it works.
"""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from reliability import originals
from reliability.broken_disk import BrokenDisk
from reliability.row import Progress, Result, Row
from reliability.spawning import Order, served
from shoecal_core.calibration.calibration import save_calibration
from shoecal_core.errors import FileError, ShoecalError, error_code
from shoecal_core.recording.recover import recover, recovered_path
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator.calibration_store import NEXT, CalibrationStore
from shoecal_ros.common.codes import Code
from shoecal_ros.serial.raw_log import RawLog

KINDS = ("full before", "full during", "read-only before", "read-only during", "broken")
FULL, UNWRITABLE = "disk-full", "file-unwritable"
"""Codes of what is refused."""
BROKEN = ("fsync", "replace")
MOST_CALLS = 14
"""Of one of these kinds while a calibration is applied, and some more."""
_NOBODY = 65534
_DISK_KIB = 1024
_LONGEST = 20_000
"""Samples; no disk here holds more."""


class BadlyTakenError(Exception):
    """A full or read-only disk was not taken as it should be."""


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    namespace = _namespace()
    order = {"first": first, "count": count, "seed": seed, "mount": bool(namespace)}
    failed, worst = 0, ""
    for done, one in enumerate(served("full_disk", order, namespace), start=1):
        failed += bool(one["problem"])
        worst = worst or one["problem"]
        progress(done)
    how = "on a tmpfs" if namespace else "with RLIMIT_FSIZE, as nothing may be mounted here"
    return Result(count, failed, worst or f"each told in one line, {how}")


def serve(order: Order) -> Iterator[dict[str, Any]]:
    """Fill disks up."""
    for number in range(order["first"], order["first"] + order["count"]):
        rng = np.random.default_rng([order["seed"], number])
        kind = KINDS[number % len(KINDS)]
        with (
            tempfile.TemporaryDirectory(prefix="shoecal-disk-") as name,
            _Disk(Path(name), mount=order["mount"]) as disk,
        ):
            problem = _problem(disk, kind, rng)
        yield {"problem": problem and f"{kind}: {problem}"}


class _Disk:
    """A small disk.

    Attributes:
        folder: of it.
    """

    def __init__(self, folder: Path, *, mount: bool) -> None:
        self.folder = folder
        self._mount = mount
        self._filler = folder / "filler"

    def __enter__(self) -> Self:
        if self._mount:
            subprocess.run(
                ["mount", "-t", "tmpfs", "-o", f"size={_DISK_KIB}k,mode=777", "tmpfs", self.folder],
                check=True,
            )
        else:
            self.folder.chmod(0o777)
        return self

    def __exit__(self, *_: object) -> None:
        self.mend()
        if self._mount:
            subprocess.run(["umount", self.folder], check=True)

    def fill(self, left: int) -> None:
        """Leave so many bytes free."""
        if not self._mount:
            _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (left, hard))
            return
        free = os.statvfs(self.folder).f_bavail * os.statvfs(self.folder).f_frsize
        with contextlib.suppress(OSError), self._filler.open("wb") as file:
            file.write(bytes(max(0, free - left)))

    def forbid(self) -> None:
        """Make it read-only; as the superuser, only where a disk of its own is mounted."""
        if self._mount:
            subprocess.run(["mount", "-o", "remount,ro", self.folder], check=True)
        else:
            self.take_rights()

    def take_rights(self) -> None:
        """Let nobody write into the folders any more; files that are open stay so."""
        for folder in (self.folder, *(each for each in self.folder.rglob("*") if each.is_dir())):
            folder.chmod(0o555)
        if os.geteuid() == 0:  # rights do not bind the superuser
            os.seteuid(_NOBODY)

    def mend(self) -> None:
        """Room and rights again."""
        if os.getuid() == 0:
            os.seteuid(0)
        if self._mount:
            subprocess.run(["mount", "-o", "remount,rw", self.folder], check=True)
        _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
        for folder in (self.folder, *(each for each in self.folder.rglob("*") if each.is_dir())):
            folder.chmod(0o777)
        self._filler.unlink(missing_ok=True)


def _problem(disk: _Disk, kind: str, rng: np.random.Generator) -> str:
    session, store = originals.session(disk.folder / "session"), _store(disk)
    store.apply(_calibration("one"), originals.START_NS)
    if kind.startswith("read-only"):
        # A change was cut before: what is left of it cannot be removed.
        save_calibration(_calibration("left"), disk.folder / "state" / NEXT)
    try:
        if kind == "broken":
            return _broken(disk, session, store, rng)
        if kind.endswith("before"):
            full = kind.startswith("full")
            disk.fill(0) if full else disk.forbid()
            code = FULL if full else UNWRITABLE
            refusal = _refused(lambda: _record(session, _LONGEST), code)
            _refused(lambda: originals.session(disk.folder / "other"), code)
            _refused(lambda: store.apply(_calibration("two"), originals.START_NS), code)
        else:
            refusal = _interrupted(disk, kind, session, rng)
            _log_without_room(disk.folder / "raw.log")
        _check_in_force(store, disk)
        disk.mend()
        _check_afterwards(disk, session, store)
    except BadlyTakenError as error:
        return str(error)
    except (OSError, AssertionError) as error:
        return repr(error)
    return "" if str(disk.folder) in refusal else f"no file is named: {refusal}"


def _interrupted(disk: _Disk, kind: str, session: Session, rng: np.random.Generator) -> str:
    """Record until there is no room; the refusal."""
    if kind.startswith("full"):
        disk.fill(int(rng.integers(4096, 200_000)))
        refusal = _refused(lambda: _record(session, _LONGEST), FULL)
    else:
        refusal = _refused(lambda: _record(session, 50, disk.take_rights), UNWRITABLE)
    disk.mend()
    for path in session.unfinished:
        try:
            recover(path, recovered_path(path))
        except ShoecalError as error:
            if "rescued" not in str(error):
                raise BadlyTakenError(f"cannot be recovered: {error}") from error
    for entry in session.runs:
        readings = session.read(entry.run).readings
        if not np.array_equal(readings.sequence[:, 0], np.arange(len(readings.time))):
            raise BadlyTakenError("readings within the recovered run are lost")
    disk.fill(0)
    return refusal


def _broken(
    disk: _Disk, session: Session, store: CalibrationStore, rng: np.random.Generator
) -> str:
    """Apply and record while the disk refuses something; then it is mended."""
    breaks = BrokenDisk(
        str(rng.choice(BROKEN)), int(rng.integers(1, MOST_CALLS)), lasting=bool(rng.integers(2))
    )
    told, names = [], ["one", ""]
    with breaks:
        try:
            store.apply(_calibration("two"), originals.START_NS)
        except ShoecalError as error:
            told.append(_told(error, UNWRITABLE))
        else:
            names = ["two", "one"]
        try:
            _record(session, 20)
        except ShoecalError as error:
            told.append(_told(error, UNWRITABLE))
    if unnamed := [one for one in told if str(disk.folder) not in one]:
        raise BadlyTakenError(f"no file is named: {unnamed[0]}")
    _check_in_force(store, disk, *names)
    _check_afterwards(disk, session, store)
    return ""


def _record(session: Session, samples: int, last: Callable[[], None] = lambda: None) -> None:
    """Record a run; do something before it is finished."""
    writer = session.new_run("landmarks", originals.SUPPORT)
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


def _log_without_room(path: Path) -> None:
    """Have a log of raw bytes end, or not begin."""
    try:
        log = RawLog(path)
    except FileError as error:
        _told(error, FULL)
        return
    log.write(bytes(2**21))
    log.close()
    if log.problem is None or log.problem.code != Code.RAW_LOG_ENDED:
        raise BadlyTakenError("a log of raw bytes does not tell that it has ended")


def _refused(what: Callable[[], object], code: str) -> str:
    """What was told of something that must be refused with this code."""
    try:
        what()
    except ShoecalError as error:
        return _told(error, code)
    raise BadlyTakenError("nothing was refused")


def _told(error: ShoecalError, code: str) -> str:
    """Its message; its code must be this one."""
    if error_code(type(error)) != code:
        raise BadlyTakenError(f"the code is {error_code(type(error))}, not {code}: {error}")
    return str(error)


def _check_in_force(
    store: CalibrationStore, disk: _Disk, current: str = "one", before: str = ""
) -> None:
    for each in (store, _store(disk)):
        if each is not store:
            each.load(originals.START_NS)
        if [one and one.id for one in (each.current, each.before)] != [current, before or None]:
            raise BadlyTakenError("another calibration is in force than before")


def _check_afterwards(disk: _Disk, session: Session, store: CalibrationStore) -> None:
    """With room and rights again everything works."""
    try:
        shutil.rmtree(disk.folder / "other", ignore_errors=True)
        _record(session, 20)
        store.apply(_calibration("two"), originals.START_NS)
    except ShoecalError as error:
        raise BadlyTakenError(f"with room again: {error}") from error
    left = [path.name for path in (disk.folder / "state").iterdir() if path.name.startswith(".")]
    if left:
        raise BadlyTakenError(f"left behind: {', '.join(left)}")


def _store(disk: _Disk) -> CalibrationStore:
    return CalibrationStore(disk.folder / "state", originals.robot(), originals.shoe())


def _calibration(identity: str) -> Any:
    return replace(originals.calibration(), id=identity)


def _namespace() -> tuple[str, ...]:
    """Words before a command that may then mount; empty where nobody may here."""
    for words in (("unshare", "--mount"), ("unshare", "--user", "--map-root-user", "--mount")):
        try:
            done = subprocess.run(
                [*words, "mount", "-t", "tmpfs", "tmpfs", "/mnt"], check=False, capture_output=True
            )
        except OSError:
            return ()
        if done.returncode == 0:
            return words
    return ()


ROW = Row(
    key="full-disk",
    fault="disk full, read-only or broken, before and during a recording",
    holds="refused before, or a clean failure, each with its code; what was recorded recovers; the "
    "calibration in force stays",
    tries=200,
    step=40,
    run=run,
)
