"""The calibrator node, of which each job and each change fails once, in a way nobody foresaw."""

from __future__ import annotations

from typing import Any

from shoecal_ros.calibrator.calibration_job import CalibrationJob
from shoecal_ros.calibrator.calibration_store import CalibrationStore
from shoecal_ros.calibrator.diagnosis_job import DiagnosisJob
from shoecal_ros.calibrator.rezeroing import RezeroServer
from shoecal_ros.nodes.calibrator import main


def fails_once(owner: type, name: str, error: Exception) -> None:
    """Let a method raise an error at its first call."""
    real = getattr(owner, name)

    def fail(*_: Any, **__: Any) -> None:
        setattr(owner, name, real)
        raise error

    setattr(owner, name, fail)


if __name__ == "__main__":
    for owner, name in (
        (CalibrationJob, "_draw"),
        (DiagnosisJob, "_check_goal"),
        (CalibrationStore, "save"),
        (RezeroServer, "_observe"),
    ):
        fails_once(owner, name, ZeroDivisionError("made up,\nof two lines"))
    main()
