"""What the calibrator's worker process does."""

from __future__ import annotations

from pathlib import Path

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import Calibration, save_calibration
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Link

CALIBRATION = "calibration.yaml"


def draw(
    link: Link, files: RobotFiles, settings: PlannerSettings, count: int, seed: int
) -> list[DoubleSupport]:
    """The double supports to visit."""
    del link
    return draw_supports(files.load_robot(), files.load_shoe(), settings, count, seed)


def solve(
    link: Link,
    folder: Path,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    made_ns: int,
    manual: Calibration | None,
) -> Calibration:
    """The calibration that a session gives; it is kept in the session's folder, too.

    Args:
        link: to the node.
        folder: of the session.
        settings, tolerances: of the fit.
        made_ns: time stamp of the calibration [ns since the epoch].
        manual: calibration of these shoes with known weights, as a prior.
    """
    del link
    calibration = calibrate_session(
        Session.open(folder),
        settings=settings,
        tolerances=tolerances,
        made_ns=made_ns,
        manual=manual,
    ).calibration
    save_calibration(calibration, folder / CALIBRATION)
    return calibration
