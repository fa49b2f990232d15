"""What a demo is asked to do, and the folder it works in."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.files import system_error
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import FILE as SESSION_FILE


@dataclass(frozen=True)
class Options:
    """Arguments of the demo.

    Attributes:
        seed: draws supports, robot and cells.
        out: folder of the results.
        robot, shoe: their files.
        reality: changes to the default reality, None for none.
        supports, train: double supports to visit, and of them for the fit.
        target: expected CoP error of each foot at which no further run trains [m]; 0: all train.
        speed: simulated over wall-clock time that is tried for.
    """

    seed: int
    out: Path
    robot: Path
    shoe: Path
    reality: Path | None
    supports: int
    train: int
    target: float
    speed: float


class Folder:
    """Where everything of a demo goes."""

    def __init__(self, out: Path) -> None:
        self.out = out.resolve()
        self.session = self.out / "session"
        self.result = self.out / "result.json"
        self.report = self.out / "report.html"
        self.calibration = self.out / "calibration.yaml"
        self.logs = self.out / "logs"
        self.work = self.out / "work"
        self.sessions = self.work / "sessions"
        self.state = self.work / "state"
        self.truth = self.work / "truth.mcap"
        self.port = self.work / "port"
        self.device = self.work / "shoe_driver.yaml"

    def prepare(self) -> None:
        """Make it, without what a demo before left there; foreign files stay.

        Raises:
            FileError: when it cannot be made, or `session` is not a demo's.
        """
        if self.session.exists() and not (self.session / SESSION_FILE).is_file():
            raise SessionError(self.session, "is no session; choose another folder with --out")
        try:
            self.out.mkdir(parents=True, exist_ok=True)
            for old in (self.session, self.logs, self.work):
                shutil.rmtree(old, ignore_errors=True)
            for file in (self.result, self.report, self.calibration):
                file.unlink(missing_ok=True)
            self.sessions.mkdir(parents=True)
        except OSError as error:
            raise system_error(self.out, error, "cannot be made") from error

    def keep_session(self) -> None:
        """Give what was recorded its place, finished or not."""
        for found in self.sessions.glob("*"):
            if found.is_dir() and not self.session.exists():
                found.rename(self.session)
