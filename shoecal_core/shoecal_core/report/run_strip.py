"""Pictures of the robot in one run of a recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.robot import Robot
from shoecal_core.report.calibration_content import CalibrationReport, RunReport
from shoecal_core.report.page import Strip
from shoecal_core.report.scene.stills import Instant, instant, stills
from shoecal_core.sensing.shoe import FEET

FloatArray = NDArray[np.float64]


def run_strip(content: CalibrationReport) -> Strip | None:
    """The run whose CoP travels farthest between feet that stand; None where no feet do.

    Raises:
        NoPictureError: where nothing can draw it.
    """
    runs = [run for run in content.runs if run.double_support and len(run.snapshot_time)]
    if not runs:
        return None
    run = max(runs, key=_travel)
    instants = [_instant(content.robot, run, index) for index in range(len(run.snapshot_time))]
    return Strip(
        f"The robot in run {run.run}",
        stills(content.robot, content.shoe, [instants])[0],
        "Posed by the recorded joint angles; limbs are drawn as thick as their mass tells. Red "
        "arrow: the calibrated force on the floor, at the CoP; red line: where the CoP has been, "
        "both seen through legs and feet; "
        f"dashed: from the CoM down. {FEET[0].capitalize()} leg blue, {FEET[1]} leg orange; "
        "the lighter floor is the hull of the sensing polygons.",
    )


def _travel(run: RunReport) -> float:
    cop = run.series("measured").cop
    known = cop[np.isfinite(cop).all(axis=1)]
    return float(np.ptp(known, axis=0).sum()) if len(known) else 0.0


def _instant(robot: Robot, run: RunReport, index: int) -> Instant:
    measured, time = run.series("measured"), float(run.snapshot_time[index])
    now = int(np.argmin(np.abs(measured.time - time)))
    trail = measured.cop[: now + 1 : max(1, len(measured.cop) // 150)]
    return instant(
        robot, f"{time:.1f} s", run.snapshot_angles[index], measured.cop[now],
        float(measured.grf[now]) / robot.weight, trail,
    )  # fmt: skip
