"""A session: the runs one robot recorded on one pair of shoes, and the files they rest on."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Generic, TypeVar

from shoecal_core.errors import (
    FileMissingError,
    FileTakenError,
    NameNotFoundError,
    ShoecalError,
)
from shoecal_core.files import (
    atomic_write,
    read_bytes,
    read_yaml,
    sha256,
    system_error,
    write_yaml,
)
from shoecal_core.recording.container import read_info
from shoecal_core.recording.errors import HashMismatchError, RecordingError, SessionError
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.listing import HINTS, RUN_FILE, ListedRun, read_listed, run_file
from shoecal_core.recording.reader import read_run
from shoecal_core.recording.run import Run
from shoecal_core.recording.truth import TruthWriter
from shoecal_core.recording.writer import RunWriter
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot_file import SESSION_FILE, SESSION_URDF
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

FORMAT = 1
FILE = SESSION_FILE
ROBOT, URDF, SHOE = "robot.yaml", SESSION_URDF, "shoe.yaml"
TRUTH = "truth"
NAMED = 5
"""Sessions that an error names."""

T = TypeVar("T")


@dataclass(frozen=True)
class RunEntry:
    """One finished run of a session.

    Attributes:
        run: its number.
        path: its file.
        info: what the file says of itself.
        hint: what it is meant for: `train`, `test`, or empty.
    """

    run: int
    path: Path
    info: RunInfo
    hint: str


def _recorded(info: RunInfo) -> dict[str, str]:
    """SHA-256 of the files that a run was recorded with."""
    return {ROBOT: info.robot_hash, URDF: info.urdf_hash, SHOE: info.shoe_hash}


def require_free(folder: Path) -> None:
    """Refuse a folder for a new session that holds something already.

    Raises:
        FileTakenError: it does, or is a file.
    """
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise FileTakenError(
            folder, "exists already; sessions are never overwritten: name another folder"
        )


def missing_text(runs: Sequence[int]) -> str:
    """Runs that were started and are gone, in words."""
    if len(runs) == 1:
        return f"run {runs[0]} was begun but its file is gone: put it back"
    return f"runs {', '.join(map(str, runs))} were begun but their files are gone: put them back"


def _within(folder: Path) -> str:
    """What to name instead of a folder that is no session: those that it holds."""
    try:
        held = sorted(file.parent for file in folder.glob(f"*/{FILE}"))
    except OSError:
        held = []
    if len(held) == 1:
        return f"name the one that it holds: {held[0]}"
    return f"name one that it holds: {', '.join(map(str, held[:NAMED]))}" if held else "name one"


class _Kept(Generic[T]):
    """What files hold, each read again only when it has changed."""

    def __init__(self, read: Callable[[Path], T]) -> None:
        self._read = read
        self._known: dict[Path, tuple[tuple[int, int, int], T]] = {}

    def of(self, path: Path) -> T:
        """What one of them holds; errors are those of reading it."""
        try:
            status = path.stat()
        except OSError:
            return self._read(path)  # which names the cure
        version = (status.st_ino, status.st_size, status.st_mtime_ns)
        known = self._known.get(path)
        if known is None or known[0] != version:
            known = self._known[path] = (version, self._read(path))
        return known[1]


class Session:
    """A folder of runs. What is on the disk counts: a run is there when its file is.

    Attributes:
        folder: the session's.
        robot, shoe_name: names.
        seed: the runs were drawn with; None where nothing was drawn.
        forced: runs are read though they were recorded with another robot or shoe file.
    """

    def __init__(
        self,
        folder: Path,
        robot: str,
        shoe_name: str,
        seed: int | None,
        listed: list[ListedRun],
        *,
        forced: bool = False,
    ) -> None:
        self.folder = folder
        self.robot = robot
        self.shoe_name = shoe_name
        self.seed = seed
        self.forced = forced
        self._listed = listed
        self._infos: _Kept[RunInfo] = _Kept(read_info)
        self._read: _Kept[Run] = _Kept(self._read_file)

    @classmethod
    def create(
        cls,
        folder: Path,
        robot_yaml: Path,
        robot_urdf: Path,
        shoe_yaml: Path,
        *,
        seed: int | None = None,
    ) -> Session:
        """Make a session with copies of the files it rests on; all of it or nothing.

        Raises:
            FileTakenError: when the folder holds something already.
            FileError: when it cannot be made, or a file cannot be used.
        """
        folder = Path(folder)
        require_free(folder)
        robot = read_yaml(robot_yaml).text("name")
        session = cls(folder, robot, load_shoe(shoe_yaml).name, seed, [])
        copies = {ROBOT: robot_yaml, URDF: robot_urdf, SHOE: shoe_yaml}
        contents = {name: read_bytes(source) for name, source in copies.items()}
        made = folder.with_name(f".{folder.name}.{secrets.token_hex(8)}")
        try:
            made.mkdir(parents=True)
            for name, content in contents.items():
                atomic_write(made / name, content)
            session._save(made)
            made.rename(folder)
        except OSError as error:
            raise system_error(folder, error, "cannot be made") from error
        finally:
            shutil.rmtree(made, ignore_errors=True)
        return session

    @classmethod
    def open(cls, folder: Path, *, force: bool = False) -> Session:
        """Open a session, interrupted ones too.

        Args:
            folder: of the session.
            force: read its runs though its robot or shoe file is another one by now.

        Raises:
            FileMissingError: no folder there.
            SessionError: a folder that is none, or has lost a file.
            VersionError: written by a newer shoecal.
        """
        folder = Path(folder)
        path = folder / FILE
        if folder.is_file():
            whole = f"; its session is {folder.parent}" if (folder.parent / FILE).is_file() else ""
            raise SessionError(folder, f"is a file; name a session's folder{whole}")
        if not folder.is_dir():
            raise FileMissingError(folder, "does not exist; record, simulate or import a session")
        if not path.is_file():
            raise SessionError(folder, f"is no session (it has no {FILE}); {_within(folder)}")
        for name in (ROBOT, URDF, SHOE):
            if not (folder / name).is_file():
                raise SessionError(folder, f"has lost its {name}; put it back")
        fields = read_yaml(path)
        fields.format(FORMAT)
        fields.only("format", "robot", "shoe", "seed", "runs")
        return cls(
            folder=folder,
            robot=fields.text("robot"),
            shoe_name=fields.text("shoe"),
            seed=fields.integer("seed") if "seed" in fields else None,
            listed=[read_listed(item) for item in fields.items("runs")],
            forced=force,
        )

    @property
    def robot_yaml(self) -> Path:
        """The robot file the runs were recorded with."""
        return self.folder / ROBOT

    @property
    def robot_urdf(self) -> Path:
        """The robot's URDF."""
        return self.folder / URDF

    @cached_property
    def shoe(self) -> Shoe:
        """The shoes the runs were recorded on."""
        return load_shoe(self.folder / SHOE)

    @property
    def runs(self) -> tuple[RunEntry, ...]:
        """Finished runs on the disk, by number.

        Raises:
            RecordingError: for a file that is no run, is damaged or bears another's number.
        """
        hints = {item.run: item.hint for item in self._listed}
        entries = []
        for run, path in self._files(finished=True):
            info = self._infos.of(path)
            if info.run != run:
                raise RecordingError(path, f"holds run {info.run}; give it its own name back")
            entries.append(RunEntry(run, path, info, hints.get(run, "")))
        return tuple(entries)

    @property
    def missing(self) -> tuple[int, ...]:
        """Runs that were begun and of which no file is left."""
        present = {run for run, _ in self._files()}
        return tuple(item.run for item in self._listed if item.run not in present)

    @property
    def unfinished(self) -> tuple[Path, ...]:
        """Files of interrupted runs that `recover` has not yet made runs of."""
        finished = {run for run, _ in self._files(finished=True)}
        return tuple(path for run, path in self._files(finished=False) if run not in finished)

    def new_run(
        self,
        motion: str,
        support: DoubleSupport | None,
        *,
        hint: str = "",
        live: bool = True,
        notes: tuple[str, ...] = (),
    ) -> RunWriter:
        """Start the next run.

        Args:
            motion: its name.
            support: pose of the right sole in the left; None where there is none.
            hint: what it is meant for: `train`, `test`, or empty.
            live: as for RunWriter.
            notes: what an import changed or left out, a line each.
        """
        taken = [run for run, _ in self._files()] + [item.run for item in self._listed]
        listed = ListedRun(max(taken, default=0) + 1, motion, support, _known_hint(hint))
        info = RunInfo(
            run=listed.run,
            motion=motion,
            support=support,
            robot=self.robot,
            shoe=self.shoe_name,
            robot_hash=sha256(self.folder / ROBOT),
            shoe_hash=sha256(self.folder / SHOE),
            urdf_hash=sha256(self.folder / URDF),
            notes=notes,
        )
        self._listed.append(listed)
        self._save(self.folder)
        return RunWriter(self.folder / listed.file, info, live=live)

    def mark(self, train: Collection[int], test: Collection[int]) -> None:
        """Write down which runs are meant to train and which to test.

        Raises:
            ShoecalError: for a run that is in both.
            NameNotFoundError: for a run that is not there.
        """
        if both := sorted({*train} & {*test}):
            raise ShoecalError(f"run {both[0]} cannot both train and test")
        entries = {entry.run: entry for entry in self.runs}
        for run in (*train, *test):
            if run not in entries:
                raise NameNotFoundError("run", str(run), [str(known) for known in entries])
        self._listed = [
            ListedRun(
                run=run,
                motion=entry.info.motion,
                support=entry.info.support,
                hint="train" if run in train else "test" if run in test else "",
            )
            for run, entry in entries.items()
        ]
        self._save(self.folder)

    def read(self, run: int) -> Run:
        """One run, checked against the session's files unless forced; its file is read once.

        Raises:
            NameNotFoundError: no such run.
            HashMismatchError: recorded with another robot or shoe.
            RecordingError: as `read_run`.
        """
        entries = self.runs
        for entry in entries:
            if entry.run == run:
                if not self.forced:
                    self._check(entry)
                return self._read.of(entry.path)
        raise NameNotFoundError("run", str(run), [str(entry.run) for entry in entries])

    def _read_file(self, path: Path) -> Run:
        return read_run(path, self.shoe)

    @property
    def changed_files(self) -> tuple[str, ...]:
        """Names of the robot and shoe files that some run was recorded with another version of."""
        present = {file: sha256(self.folder / file) for file in (ROBOT, URDF, SHOE)}
        infos = [entry.info for entry in self.runs]
        recorded = {file: {_recorded(info)[file] for info in infos} for file in present}
        return tuple(file for file, digest in present.items() if recorded[file] - {digest})

    def truth_path(self, run: int) -> Path:
        """Where the simulated truth of a run is kept, for `read_truth`."""
        return self.folder / TRUTH / run_file(run)

    def new_truth(self, info: RunInfo) -> TruthWriter:
        """Start the truth file of the run with this info.

        Raises:
            FileError: when its folder or itself cannot be made.
        """
        path = self.truth_path(info.run)
        try:
            path.parent.mkdir(exist_ok=True)
        except OSError as error:
            raise system_error(path, error, "cannot be made") from error
        return TruthWriter(path, info)

    def _check(self, entry: RunEntry) -> None:
        for file, digest in _recorded(entry.info).items():
            present = sha256(self.folder / file)
            if present != digest:
                raise HashMismatchError(entry.path, file, digest, present)

    def _files(self, *, finished: bool | None = None) -> list[tuple[int, Path]]:
        """Run files by number; finished ones, unfinished ones, or both."""
        found = []
        for path in self.folder.iterdir():
            match = RUN_FILE.fullmatch(path.name)
            if match and finished in (None, match[2] is None):
                found.append((int(match[1]), path))
        return sorted(found)

    def _save(self, folder: Path) -> None:
        content = {"format": FORMAT, "robot": self.robot, "shoe": self.shoe_name}
        seed = {} if self.seed is None else {"seed": self.seed}
        runs = [item.to_yaml() for item in self._listed]
        write_yaml(folder / FILE, {**content, **seed, "runs": runs})


def _known_hint(name: str) -> str:
    if name not in HINTS:
        raise NameNotFoundError("set", name, HINTS)
    return name
