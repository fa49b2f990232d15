"""The calibration in force, the one before it, and their files."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.calibration.calibration import Calibration, load_calibration, save_calibration
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import Shoe

CURRENT, BEFORE = "calibration.yaml", "calibration_before.yaml"


class NotApplicableError(ShoecalError):
    """A calibration that must not be applied here."""


class CalibrationStore:
    """Keeps calibrations in a folder, so that they survive a restart.

    Attributes:
        current: in force, None while uncalibrated.
        before: to roll back to, None where there is none.
    """

    def __init__(self, folder: Path, robot: Robot, shoe: Shoe) -> None:
        self.current: Calibration | None = None
        self.before: Calibration | None = None
        self._folder = folder
        self._robot = robot
        self._shoe = shoe

    def load(self) -> str:
        """Take what is in the folder; what could not be taken and its cure, else empty."""
        problems = []
        for name in (CURRENT, BEFORE):
            path = self._folder / name
            if not path.is_file():
                continue
            try:
                calibration = load_calibration(path)
                self.check(calibration)
            except ShoecalError as error:
                problems.append(str(error) if isinstance(error, FileError) else f"{path}: {error}")
                continue
            if name == CURRENT:
                self.current = calibration
            else:
                self.before = calibration
        return "; ".join(problems)

    def check(self, calibration: Calibration, *, force: bool = False) -> None:
        """Whether a calibration may be applied to this robot and these shoes.

        Args:
            calibration: to be applied.
            force: also one that was made with other versions of the robot or the shoe file.

        Raises:
            NotApplicableError, WrongShoeError: with the cure.
        """
        calibration.sensing(self._shoe)
        if calibration.verdict == "FAIL":
            raise NotApplicableError(
                f"calibration '{calibration.id}' failed its own checks "
                f"({'; '.join(calibration.reasons)}); calibrate anew"
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

    def apply(self, calibration: Calibration) -> None:
        """Put a checked calibration in force; the one in force is kept for rollback.

        Raises:
            FileError: when it cannot be saved; then nothing has changed.
        """
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(
                self._folder, f"cannot be made ({error.strerror}); correct state_dir"
            ) from error
        if self.current is not None:
            save_calibration(self.current, self._folder / BEFORE)
            self.before = self.current
        save_calibration(calibration, self._folder / CURRENT)
        self.current = calibration

    def rollback(self) -> Calibration:
        """Put the calibration before in force again; the one in force becomes the one before.

        Raises:
            NotApplicableError: when there is none.
        """
        if self.before is None:
            raise NotApplicableError("there is no calibration before this one to go back to")
        calibration = self.before
        self.apply(calibration)
        return calibration
