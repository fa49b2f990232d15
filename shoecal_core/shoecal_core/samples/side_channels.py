"""What a run may hold besides angles and readings, at F times of these [s since its start]."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.robot.robot import Robot

LEAST_KNOWN = 0.5
"""Share of its readings in which an IMU must give an orientation, for any to be used."""


def efforts(run: Run, robot: Robot, time: FloatArray) -> FloatArray | None:
    """(F, m) of the joints [N m]; None where those of the legs were not recorded."""
    if run.joints.effort is None:
        return None
    efforts = np.zeros((len(time), len(robot.joint_names)))
    recorded = dict(zip(run.joints.names, run.joints.effort.T, strict=True))
    for index, name in enumerate(robot.joint_names):
        if name not in recorded or not np.isfinite(recorded[name]).all():
            if index in robot.moved:
                return None
            continue
        efforts[:, index] = np.interp(time, run.joints.time, recorded[name])
    return efforts if np.any(efforts) else None


def upwards(run: Run, time: FloatArray) -> FloatArray | None:
    """(F, 3) the direction upwards in the base's frame: a row of its rotation; None without it."""
    imu = run.imu
    if imu is None:
        return None
    known = np.isfinite(imu.quaternion).all(axis=1)
    if len(imu.time) < 2 or known.mean() < LEAST_KNOWN:
        return None
    x, y, z, w = imu.quaternion[known].T
    up = np.stack((2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)), axis=1)
    return np.stack([np.interp(time, imu.time[known], axis) for axis in up.T], axis=1)


def temperature(run: Run, time: FloatArray) -> FloatArray | None:
    """(F,) of the shoes [degC]; the mean of their cells' where only these report it."""
    if run.shoe_temperature is not None:
        return np.interp(time, run.shoe_temperature.time, run.shoe_temperature.value)
    cells = run.readings.temperature
    known = np.isfinite(cells).any(axis=1)
    if not known.any():
        return None
    mean = np.nanmean(cells[known], axis=1)
    return np.interp(time, run.readings.time[known], mean)
