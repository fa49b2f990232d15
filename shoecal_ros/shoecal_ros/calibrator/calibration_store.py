"""The calibration in force, the one before it, and their files.

A change is one rename: the new file is laid beside the others and noted in the record, then the
one in force becomes the one before, then the new one takes its place. Killed at any moment, what
is loaded next is the old pair or the new one, whole.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.calibration.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.calibration.checks import tell_reasons
from shoecal_core.calibration.plausible import check_plausible
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.files import read_yaml, sha256, write_yaml
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import Shoe

CURRENT, BEFORE, NEXT = "calibration.yaml", "calibration_before.yaml", "calibration_next.yaml"
RECORD = "in_force.yaml"
RECORD_FORMAT = 1
LATEST_NS = (2**31 - 1) * 10**9
"""Messages hold no later time."""


class NotApplicableError(ShoecalError):
    """A calibration that must not be applied here."""


@dataclass(frozen=True)
class Entry:
    """When and where a calibration was put in force.

    Attributes:
        since_ns: when [ns].
        robot_hash, shoe_hash: files of robot and shoe that were in use.
    """

    since_ns: int
    robot_hash: str
    shoe_hash: str


class CalibrationStore:
    """Keeps calibrations in a folder, so that they survive a restart.

    `save` may run in another thread, one at a time: it changes files only. `take` says that what
    it has saved is in force.

    Attributes:
        current: in force, None while uncalibrated.
        before: to roll back to, None where there is none.
        since_ns: when the current one was put in force [ns].
    """

    def __init__(self, folder: Path, robot: Robot, shoe: Shoe) -> None:
        self.current: Calibration | None = None
        self.before: Calibration | None = None
        self.since_ns = 0
        self._folder = folder
        self._robot = robot
        self._shoe = shoe
        self._record: dict[str, Entry] = {}

    def load(self, now_ns: int, *, warned: bool = False) -> str:
        """Take what is in the folder; what could not be taken and its cure, else empty.

        What was accepted here counts as long as robot and shoe are the same.

        Args:
            now_ns: since when a file is in force that somebody laid there.
            warned: take such a file also when its checks warn.
        """
        problems = []
        try:
            self._record = _read_record(self._folder / RECORD)
            self._recover()
        except ShoecalError as error:
            problems.append(str(error))
        for name in (CURRENT, BEFORE):
            path = self._folder / name
            try:
                if not _is_there(path):
                    continue
                calibration, digest = load_calibration(path), sha256(path)
                known = self._record.get(digest)
                accepted = known is not None and known == self._entry(known.since_ns)
                self.check(calibration, force=accepted, warned=warned)
            except ShoecalError as error:
                problems.append(str(error) if isinstance(error, FileError) else f"{path}: {error}")
                continue
            if name == BEFORE:
                self.before = calibration
                continue
            self.current = calibration
            self.since_ns = now_ns if known is None else known.since_ns
            if not accepted:
                # A folder that cannot be written is told when something is to be kept in it.
                with contextlib.suppress(FileError):
                    self._note(digest, self.since_ns)
        return "; ".join(problems)

    def check(self, calibration: Calibration, *, force: bool = False, warned: bool = False) -> None:
        """Whether a calibration may be applied to this robot and these shoes.

        Args:
            calibration: to be applied.
            force: also one that was made with other versions of the robot or the shoe file, or
                whose checks warn.
            warned: also one whose checks warn.

        Raises:
            NotApplicableError, WrongShoeError, ImplausibleError: with the cure.
        """
        calibration.sensing(self._shoe)
        check_plausible(calibration, self._shoe, self._robot.weight)
        reasons = tell_reasons(calibration.reasons)
        if calibration.verdict == "FAIL":
            raise NotApplicableError(
                f"calibration '{calibration.id}' failed its own checks ({reasons}); calibrate anew"
            )
        if force:
            return
        for kind, made, present in (
            ("robot", calibration.robot_hash, self._robot.digest),
            ("shoe", calibration.shoe_hash, self._shoe.digest),
        ):
            if made != present:
                raise NotApplicableError(
                    f"calibration '{calibration.id}' was made with another {kind} file than the "
                    f"one in use; calibrate anew, or set it with force"
                )
        if calibration.verdict == "WARN" and not warned:
            raise NotApplicableError(
                f"the checks of calibration '{calibration.id}' warn ({reasons}); follow them and "
                "calibrate anew, or set it with force"
            )

    def save(self, calibration: Calibration, now_ns: int) -> bool:
        """Save a checked calibration so that it is loaded next, and the one in force before it.

        Args:
            calibration: to be put in force.
            now_ns: since when it will be [ns].

        Returns:
            Whether it is to be taken; not where it is in force already, which then stays so.

        Raises:
            FileError: when it cannot be saved; then nothing has changed.
        """
        current, before, fresh = (self._folder / name for name in (CURRENT, BEFORE, NEXT))
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                self._folder, f"cannot be made ({error.strerror}); correct state_dir"
            ) from error
        save_calibration(calibration, fresh)
        _require_readable(fresh)
        digest = sha256(fresh)
        if self.current is not None and _is_there(current) and sha256(current) == digest:
            _remove(fresh)
            return False
        self._note(digest, now_ns)
        if self.current is not None:
            # Somebody may have taken the file away; what it held is in force all the same.
            if not _is_there(current):
                save_calibration(self.current, current)
            _rename(current, before)
        try:
            _rename(fresh, current)
        except FileError:
            # Nothing has changed, neither here nor for the next start.
            if self.current is not None:
                save_calibration(self.current, current)
            raise
        return True

    def take(self, calibration: Calibration, now_ns: int) -> None:
        """Have what was saved in force; the one in force is kept for rollback.

        Args:
            calibration: as `save` took it.
            now_ns: likewise.
        """
        if self.current is not None:
            self.before = self.current
        self.current, self.since_ns = calibration, now_ns

    def apply(self, calibration: Calibration, now_ns: int) -> None:
        """Save a checked calibration and take it; arguments and errors as those of `save`."""
        if self.save(calibration, now_ns):
            self.take(calibration, now_ns)

    def one_before(self) -> Calibration:
        """What to roll back to.

        Raises:
            NotApplicableError: when there is none.
        """
        if self.before is None:
            raise NotApplicableError("there is no calibration before this one to go back to")
        return self.before

    # The record

    def _entry(self, since_ns: int) -> Entry:
        return Entry(since_ns, self._robot.digest, self._shoe.digest)

    def _note(self, digest: str, since_ns: int) -> None:
        """Note a file that is to be in force, and forget those that are gone."""
        files = (self._folder / name for name in (CURRENT, BEFORE, NEXT))
        present = {sha256(path) for path in files if _is_there(path)}
        kept = {known: entry for known, entry in self._record.items() if known in present}
        record = {**kept, digest: self._entry(since_ns)}
        _write_record(self._folder / RECORD, record)
        self._record = record

    def _recover(self) -> None:
        """End a change that was interrupted: as if it had been made, or never begun."""
        current, fresh = self._folder / CURRENT, self._folder / NEXT
        if not _is_there(fresh):
            return
        if _is_there(current) or sha256(fresh) not in self._record:
            _remove(fresh)
        else:
            _rename(fresh, current)


def _require_readable(path: Path) -> None:
    """What could not be read at the next start is not put in force now."""
    try:
        load_calibration(path)
    except FileError as error:
        _remove(path)
        raise NotApplicableError(f"no whole calibration: {error.field} {error.problem}") from error


def _is_there(path: Path) -> bool:
    """Whether there is such a file."""
    try:
        return path.is_file()
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror}); correct its rights") from error


def _remove(path: Path) -> None:
    """Remove a file."""
    try:
        path.unlink()
    except OSError as error:
        raise FileError(
            path, f"cannot be removed ({error.strerror}); remove it, or correct state_dir"
        ) from error


def _rename(source: Path, target: Path) -> None:
    """Rename a file, durably."""
    try:
        source.replace(target)
        folder = os.open(target.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        raise FileError(target, f"cannot be written ({error.strerror})") from error


def _read_record(path: Path) -> dict[str, Entry]:
    """Entries by the SHA-256 of their calibration's file."""
    if not _is_there(path):
        return {}
    fields = read_yaml(path)
    fields.format(RECORD_FORMAT)
    fields.only("format", "calibrations")
    record = {}
    for item in fields.items("calibrations"):
        item.only("file_hash", "since_ns", "robot_hash", "shoe_hash")
        since_ns = item.integer("since_ns", minimum=0)
        if since_ns > LATEST_NS:
            raise item.error("since_ns", "lies beyond what a stamp holds; delete this file")
        record[item.text("file_hash")] = Entry(
            since_ns, item.text("robot_hash"), item.text("shoe_hash")
        )
    return record


def _write_record(path: Path, record: Mapping[str, Entry]) -> None:
    write_yaml(
        path,
        {
            "format": RECORD_FORMAT,
            "calibrations": [
                {
                    "file_hash": digest,
                    "since_ns": entry.since_ns,
                    "robot_hash": entry.robot_hash,
                    "shoe_hash": entry.shoe_hash,
                }
                for digest, entry in record.items()
            ],
        },
    )
