"""The calibration in force, the one before it, and their files.

A change is one rename: the new file and a copy of the one in force are laid next to the others,
then the new one takes its place, and after that the copy its own as the one before. Killed at any
moment, what is loaded next is the old pair or the new one, whole; the old one, too, where the disk
refuses anything up to that rename, or to make it durable.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from shoecal_core.errors import FileError, ShoecalError, error_code
from shoecal_core.estimation.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.estimation.checks.plausible import check_plausible
from shoecal_core.files import make_folder, read_error, sha256, sync_folder, system_error
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.shoe.shoe import Shoe
from shoecal_ros.calibrator.calibration_record import RecordEntry, read_record, write_record
from shoecal_ros.common.codes import Problem, joined
from shoecal_ros.common.origin import Origin

CURRENT, BEFORE = "calibration.yaml", "calibration_before.yaml"
NEXT, BEFORE_NEXT = "calibration_next.yaml", "calibration_before_next.yaml"
"""Laid ready for a change. While the first is there the change is not made."""
RECORD = "in_force.yaml"
AHEAD_NS = 60 * 10**9
"""By which another computer's clock may be ahead of this one's."""


class NotApplicableError(ShoecalError):
    """A calibration that must not be applied here."""


class CalibrationStore:
    """Keeps calibrations in a folder, so that they survive a restart.

    `save` may run in another thread, one at a time: it changes files only. `take` says that what
    it has saved is in force.

    Attributes:
        current: in force, None while uncalibrated.
        before: to roll back to, None where there is none.
        since_ns: when the current one was put in force [ns].
        origin, origin_before: where each was made, None where there is none.
    """

    def __init__(self, folder: Path, robot: Robot, shoe: Shoe, *, simulated: bool = False) -> None:
        """Nothing is loaded yet.

        Args:
            folder: of the files.
            robot, shoe: in use.
            simulated: whether time is simulated, and robot and shoe with it.
        """
        self.current: Calibration | None = None
        self.before: Calibration | None = None
        self.since_ns = 0
        self.origin: Origin | None = None
        self.origin_before: Origin | None = None
        self._simulated = simulated
        self._folder = folder
        self._robot = robot
        self._shoe = shoe
        self._record: dict[str, RecordEntry] = {}

    def load(self, now_ns: int, *, warned: bool = False) -> Problem | None:
        """Take what is in the folder; what could not be taken and its cure, else None.

        What was accepted here counts as long as robot and shoe are the same.

        Args:
            now_ns: since when a file is in force that somebody laid there.
            warned: take such a file also when its checks warn.
        """
        problems: list[Problem] = []
        for step in (self._read_record, self._tidy):
            try:
                step()
            except ShoecalError as error:
                problems.append(Problem.of(error))
        for name in (CURRENT, BEFORE):
            path = self._folder / name
            try:
                if not _is_there(path):
                    continue
                calibration, digest = load_calibration(path), sha256(path)
                known = self._record.get(digest)
                origin = _origin_of(calibration, known)
                accepted = known is not None and (known.robot_hash, known.shoe_hash) == self._hashes
                # The clock of a computer without a battery may be behind what was accepted here.
                latest_ns = None if accepted else now_ns
                self.check(calibration, origin, force=accepted, warned=warned, now_ns=latest_ns)
            except ShoecalError as error:
                reported = str(error) if isinstance(error, FileError) else f"{path}: {error}"
                problems.append(Problem(error_code(type(error)), reported))
                continue
            if name == BEFORE:
                self.before, self.origin_before = calibration, origin
                continue
            self.current, self.origin = calibration, origin
            self.since_ns = now_ns if known is None else known.since_ns
            if not accepted:
                # A folder that cannot be written is reported when something is to be kept in it.
                with contextlib.suppress(FileError):
                    self._note({**self._record, digest: self._entry(self.since_ns, origin)})
        return joined(problems)

    def check(
        self,
        calibration: Calibration,
        origin: Origin | None = None,
        *,
        force: bool = False,
        warned: bool = False,
        now_ns: int | None = None,
    ) -> None:
        """Whether a calibration may be applied to this robot and these shoes.

        Args:
            calibration: to be applied.
            origin: where it was made; None: as its time stamp says.
            force: also one that was made with other versions of the robot or the shoe file, or
                whose checks warn.
            warned: also one whose checks warn.
            now_ns: wall-clock time that it must not be made after [ns]; None: whenever.

        Raises:
            NotApplicableError, WrongShoeError, ImplausibleError: with the cure.
        """
        robot = self._robot
        calibration.sensing(self._shoe)
        # What its own checks found is the cause of numbers that cannot be.
        reasons = list_reasons(calibration.reasons)
        if calibration.verdict == "FAIL":
            raise NotApplicableError(
                f"calibration '{calibration.id}' failed its own checks ({reasons}); calibrate again"
            )
        check_plausible(calibration, self._shoe, robot.weight, robot.mass_std * GRAVITY)
        origin = origin or Origin.of(calibration)
        if origin.simulated != self._simulated:
            here, cure = "wall-clock time", "on the robot itself"
            if self._simulated:
                here, cure = "simulated time", "in the simulation, or run without use_sim_time"
            raise NotApplicableError(
                f"calibration '{calibration.id}' was made {origin}, but this node runs in {here}; "
                f"calibrate {cure}"
            )
        if not self._simulated and now_ns is not None and calibration.made_ns > now_ns + AHEAD_NS:
            raise NotApplicableError(
                f"calibration '{calibration.id}' was made more than {AHEAD_NS // 10**9} s from "
                "now; set the clocks of both computers, or calibrate again"
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
                    f"one in use; calibrate again, or set it with force"
                )
        if calibration.verdict == "WARN" and not warned:
            raise NotApplicableError(
                f"the checks of calibration '{calibration.id}' warn ({reasons}); follow them and "
                "calibrate again, or set it with force"
            )

    def save(self, calibration: Calibration, now_ns: int, origin: Origin | None = None) -> bool:
        """Save a checked calibration so that it is loaded next, and the one in force before it.

        Args:
            calibration: to be put in force.
            now_ns: since when it will be [ns].
            origin: where it was made; None: as its time stamp says.

        Returns:
            Whether it is to be taken; not where it is in force already, which then stays so.

        Raises:
            FileError: when it cannot be saved; then nothing has changed.
            NotApplicableError: in simulated time where the folder is that of a real robot.
        """
        current, fresh, kept = (self._folder / name for name in (CURRENT, NEXT, BEFORE_NEXT))
        make_folder(self._folder, "correct state_dir")
        self._tidy()
        if self._simulated:
            self._require_no_real_one(current)
        with contextlib.ExitStack() as undo:
            undo.callback(self._give_up)
            save_calibration(calibration, fresh)
            _require_readable(fresh)
            digest, noted = sha256(fresh), dict(self._record)
            if self.current is not None:
                save_calibration(self.current, kept)
                same = sha256(kept)
                if digest == same and _is_there(current) and sha256(current) == digest:
                    return False
                noted[same] = self._entry(self.since_ns, self.origin)
            undo.callback(self._note_again, noted)
            self._note({**noted, digest: self._entry(now_ns, origin or Origin.of(calibration))})
            _rename(fresh, current)
            undo.callback(self._go_back)
            sync_folder(current)
            undo.pop_all()
        # The change is made. What cannot be tidied up now is before the next one, or at the start.
        with contextlib.suppress(FileError):
            self._tidy()
        return True

    def take(self, calibration: Calibration, now_ns: int, origin: Origin | None = None) -> None:
        """Have what was saved in force; the one in force is kept for rollback.

        Args:
            calibration, now_ns, origin: as `save` took them.
        """
        if self.current is not None:
            self.before, self.origin_before = self.current, self.origin
        self.current, self.since_ns = calibration, now_ns
        self.origin = origin or Origin.of(calibration)

    def apply(self, calibration: Calibration, now_ns: int, origin: Origin | None = None) -> None:
        """Save a checked calibration and take it; arguments and errors as those of `save`."""
        if self.save(calibration, now_ns, origin):
            self.take(calibration, now_ns, origin)

    def one_before(self) -> tuple[Calibration, Origin]:
        """What to roll back to, and where it was made.

        Raises:
            NotApplicableError: when there is none.
        """
        if self.before is None or self.origin_before is None:
            raise NotApplicableError(
                "there is no calibration before this one to go back to; set or make another"
            )
        return self.before, self.origin_before

    # Steps of a change

    def _require_no_real_one(self, path: Path) -> None:
        """A simulation does not displace the calibration of a real robot."""
        if not _is_there(path):
            return
        try:
            there = load_calibration(path)
        except FileError:
            return  # no calibration at all: nothing is lost
        if not _origin_of(there, self._record.get(sha256(path))).simulated:
            raise NotApplicableError(
                f"{path} was made in wall-clock time and this node runs in simulated time; give "
                "the simulation a state_dir of its own"
            )

    def _tidy(self) -> None:
        """End a change that was interrupted: as if it had been made, or never begun."""
        fresh, kept = self._folder / NEXT, self._folder / BEFORE_NEXT
        if not _is_there(fresh):
            if _is_there(kept):
                _rename(kept, self._folder / BEFORE)
            return
        # In this order: without the first file the second would be taken for that of a change.
        if _is_there(kept):
            _remove(kept)
        _remove(fresh)

    def _go_back(self) -> None:
        """Undo the rename that is the change."""
        current, kept = self._folder / CURRENT, self._folder / BEFORE_NEXT
        try:
            _rename(kept, current) if _is_there(kept) else _remove(current)
        except FileError as error:
            raise type(error)(
                current,
                "holds what is not in force, as the disk refused it, and cannot be put back: "
                "repair the disk and set a calibration again, before the next start takes this one",
            ) from error

    def _give_up(self) -> None:
        """Remove what was laid ready; what is left of it is removed before the next change."""
        with contextlib.suppress(FileError):
            self._tidy()

    # The record

    @property
    def _hashes(self) -> tuple[str, str]:
        return self._robot.digest, self._shoe.digest

    def _entry(self, since_ns: int, origin: Origin | None) -> RecordEntry:
        return RecordEntry(since_ns, *self._hashes, origin)

    def _note(self, record: Mapping[str, RecordEntry]) -> None:
        """Note files that are in force, or were; forget those that are gone."""
        files = (self._folder / name for name in (CURRENT, BEFORE, NEXT, BEFORE_NEXT))
        present = {sha256(path) for path in files if _is_there(path)}
        kept = {digest: entry for digest, entry in record.items() if digest in present}
        write_record(self._folder / RECORD, kept)
        self._record = kept

    def _read_record(self) -> None:
        path = self._folder / RECORD
        self._record = read_record(path) if _is_there(path) else {}

    def _note_again(self, record: dict[str, RecordEntry]) -> None:
        """Note what was before; left over, an entry lets nothing in but the file it is of."""
        self._record = record
        with contextlib.suppress(FileError):
            self._note(record)


def _origin_of(calibration: Calibration, known: RecordEntry | None) -> Origin:
    """Where a file's calibration was made: as noted, else as its time stamp says."""
    noted = None if known is None else known.origin
    return noted or Origin.of(calibration)


def _require_readable(path: Path) -> None:
    """What could not be read at the next start is not put in force now."""
    try:
        load_calibration(path)
    except FileError as error:
        if isinstance(error.__cause__, OSError):
            raise  # it is the disk
        raise NotApplicableError(f"no whole calibration: {error.field} {error.problem}") from error


def _is_there(path: Path) -> bool:
    """Whether there is such a file."""
    try:
        return path.is_file()
    except OSError as error:
        raise read_error(path, error, "correct its rights") from error


def _remove(path: Path) -> None:
    """Remove a file."""
    try:
        path.unlink()
    except OSError as error:
        cure = "remove it, or correct state_dir"
        raise system_error(path, error, "cannot be removed", cure) from error


def _rename(source: Path, target: Path) -> None:
    """Rename a file."""
    try:
        source.replace(target)
    except OSError as error:
        cure = "check the disk of state_dir"
        raise system_error(target, error, "cannot be written", cure) from error
