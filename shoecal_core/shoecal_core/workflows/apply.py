"""Recorded readings under a calibration: GRF and CoP of every sample of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.align import interpolate_joints
from shoecal_core.recording.run import Run
from shoecal_core.recording.schemas import GOOD
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.aligned import MAX_JOINT_GAP_S, align, recorded_joints
from shoecal_core.samples.zeros import with_own_zeros
from shoecal_core.screening.extract import zeros_of
from shoecal_core.shoe.sensing import Measured, Sensing
from shoecal_core.shoe.shoe import FEET


@dataclass(frozen=True)
class Applied:
    """What calibrated shoes measured in a run, at its T readings.

    Attributes:
        time: (T,) since the run's start [s].
        measured: of each foot; NaN where a channel of it gave nothing good.
        support: (T, 3) dx, dy [m] and dtheta [rad] of the right sole in the left sole's frame, by
            the joint angles; NaN where none were recorded.
        cop: (T, 2) of both feet in the left sole's frame [m]; NaN where it is not known.
    """

    time: FloatArray
    measured: Measured
    support: FloatArray
    cop: FloatArray

    def columns(self) -> dict[str, FloatArray]:
        """Each quantity (T,) by its name and unit."""
        found = {"time_s": self.time, "grf_n": self.measured.total_grf}
        found |= {"cop_x_m": self.cop[:, 0], "cop_y_m": self.cop[:, 1]}
        for index, foot in enumerate(FEET):
            found[f"{foot}_grf_n"] = self.measured.grf[:, index]
            for axis, name in enumerate("xy"):
                found[f"{foot}_cop_{name}_m"] = self.measured.cop[:, index, axis]
        names = ("dx_m", "dy_m", "dtheta_rad")
        return found | dict(zip(names, self.support.T, strict=True))


def apply(run: Run, sensing: Sensing, kinematics: Kinematics) -> Applied:
    """Measure a run with calibrated shoes.

    Raises:
        JointsMissingError: the run's joints are not the robot's.
    """
    readings, robot = run.readings, kinematics.robot
    good = np.isfinite(readings.value) & (readings.status == GOOD)
    measured = sensing.measure(np.where(good, readings.value, np.nan))
    names = recorded_joints(run, robot)
    angles, covered = interpolate_joints(run.joints, readings.time, MAX_JOINT_GAP_S, names=names)
    states = kinematics.states(robot.from_measured(names, angles[covered]))
    support = np.full((len(readings.time), 3), np.nan)
    support[covered] = np.column_stack((states.translation[:, :2], states.yaw))
    return Applied(readings.time, measured, support, _both(measured, support))


def at_own_zeros(run: Run, sensing: Sensing, kinematics: Kinematics) -> Sensing:
    """With the zeros of feet that hang in the air in this run; as it is where none does."""
    aligned = align(run, sensing.shoe, kinematics)
    zeros = zeros_of(run, aligned, sensing.shoe, kinematics)
    parameters = with_own_zeros(sensing.shoe, sensing.parameters, zeros)
    return Sensing(sensing.shoe, parameters, sensing.corrections, sensing.minimum_force)


def _both(measured: Measured, support: FloatArray) -> FloatArray:
    """(T, 2) CoP of both feet in the left sole's frame, the floor taken as one level [m]."""
    x, y = measured.cop[:, 1].T
    cosine, sine = np.cos(support[:, 2]), np.sin(support[:, 2])
    right = np.column_stack((cosine * x - sine * y, sine * x + cosine * y)) + support[:, :2]
    in_left = np.stack((measured.cop[:, 0], right), axis=1)
    both = replace(measured, cop=in_left).combined_cop(DoubleSupport(0.0, 0.0, 0.0))
    # A right foot that carries load, where is not known.
    both[np.isfinite(x) & ~np.isfinite(right[:, 0])] = np.nan
    return both
