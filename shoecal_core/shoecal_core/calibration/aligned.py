"""Joint angles and readings of a run at the same instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import FileError
from shoecal_core.model.kinematics import BodyStates, Kinematics
from shoecal_core.model.robot import Robot
from shoecal_core.recording.align import interpolate_joints
from shoecal_core.recording.run import Run
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]
MAX_JOINT_GAP_S = 0.1
"""Readings between joint angles further apart than this have no model value."""
MIN_SAMPLES = 50
GOOD = 0


@dataclass(frozen=True)
class Aligned:
    """Readings and body states at the same T instants.

    Attributes:
        time: (T,) since the run's start [s].
        readings: (T, n) raw, all finite.
        joint_angles: (T, m) of the whole robot [rad].
        states: what the joint angles say.
    """

    time: FloatArray
    readings: FloatArray
    joint_angles: FloatArray
    states: BodyStates


def align(run: Run, shoe: Shoe, kinematics: Kinematics) -> Aligned:
    """Joint angles interpolated to the readings; what has no partner is left out.

    Raises:
        JointsMissingError: the run's joints are not the robot's.
        FileError: too little remains.
    """
    good = np.isfinite(run.readings.value).all(axis=1) & (run.readings.status == GOOD).all(axis=1)
    time = run.readings.time[good]
    names = _told_joints(run, kinematics.robot)
    measured, covered = interpolate_joints(run.joints, time, MAX_JOINT_GAP_S, names=names)
    angles = kinematics.robot.from_measured(names, measured)
    if covered.sum() < MIN_SAMPLES:
        raise FileError(
            run.path,
            f"only {int(covered.sum())} samples have both good readings of all {len(shoe.names)} "
            "channels and joint angles; check that both were recorded, with stamps of one clock",
        )
    angles = angles[covered]
    return Aligned(
        time[covered], run.readings.value[good][covered], angles, kinematics.states(angles)
    )


def _told_joints(run: Run, robot: Robot) -> list[str]:
    """The robot's joints that were recorded; some drivers tell NaN for optional ones."""
    told = np.asarray(np.isfinite(run.joints.position).any(axis=0))
    return [
        name
        for name, is_told in zip(run.joints.names, told.tolist(), strict=True)
        if name in robot.joint_names and (is_told or name not in robot.optional)
    ]
