"""Pictures of the robot in one run of a recording."""

from __future__ import annotations

import numpy as np

from shoecal_core.report.calibration_content import CalibrationReport, RunReport
from shoecal_core.report.page import StillStrip
from shoecal_core.report.scene.stills import StillInstant, instant, stills
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET


def run_strip(content: CalibrationReport) -> StillStrip | None:
    """The first run between feet that stand; None where no feet do.

    Training runs are listed first, so it is the one that their section begins with.

    Raises:
        NoPictureError: where nothing can draw it.
    """
    standing = (run for run in content.runs if run.double_support and len(run.snapshot_time))
    run = next(standing, None)
    if run is None:
        return None
    instants = [_instant(content.robot, run, index) for index in range(len(run.snapshot_time))]
    return StillStrip(
        f"The robot in run {run.run}",
        stills(content.robot, content.shoe, [instants])[0],
        "Posed by the recorded joint angles; limbs are as thick as their mass requires. Red "
        "arrow: the calibrated force on the floor, at the CoP; red line: where the CoP has been, "
        "both seen through legs and feet; "
        f"dashed: from the CoM down. {FEET[0].capitalize()} leg blue, {FEET[1]} leg orange; "
        "the lighter floor is the hull of the sensing polygons.",
    )


def _instant(robot: Robot, run: RunReport, index: int) -> StillInstant:
    measured, time = run.series("measured"), float(run.snapshot_time[index])
    now = int(np.argmin(np.abs(measured.time - time)))
    trail = measured.cop[: now + 1 : max(1, len(measured.cop) // 150)]
    return instant(
        robot, f"{time:.1f} s", run.snapshot_angles[index], measured.cop[now],
        float(measured.grf[now]) / robot.weight, trail,
    )  # fmt: skip
