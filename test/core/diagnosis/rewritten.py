"""Sessions written anew with something wrong in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from shoecal_core.recording import messages, schemas
from shoecal_core.recording.run import JointSamples, Readings, Run
from shoecal_core.recording.session import ROBOT, SHOE, URDF, Session

Change = Callable[[Run], Run]


def rewritten(session: Session, folder: Path, runs: Sequence[int], change: Change) -> Session:
    """Some runs, changed, with nothing in them but joint angles and readings."""
    made = Session.create(folder, *(session.folder / name for name in (ROBOT, URDF, SHOE)))
    for number in runs:
        run = change(session.read(number))
        with made.new_run(run.info.motion, run.info.support) as writer:
            for time, position in zip(run.joints.time, run.joints.position, strict=True):
                stamp = run.start_ns + round(1e9 * time)
                told = messages.joint_state(stamp, run.joints.names, position)
                writer.write(schemas.JOINT_STATES, told, stamp)
            readings = run.readings
            for index, (time, value) in enumerate(zip(readings.time, readings.value, strict=True)):
                stamp = run.start_ns + round(1e9 * time)
                volts = messages.shoe_voltages(
                    stamp, index, readings.names, value, readings.status[index]
                )
                writer.write(schemas.VOLTAGES, volts, stamp)
    return made


def shifted(run: Run, late: float) -> Run:
    """Joints stamped late by so much; where it is less than zero, readings [s]."""
    joints, readings = run.joints, run.readings
    return replace(
        run,
        joints=replace(joints, time=joints.time + max(late, 0.0)),
        readings=replace(readings, time=readings.time + max(-late, 0.0)),
    )


def kept(run: Run, keep: Callable[[np.ndarray[tuple[int], np.dtype[np.float64]]], object]) -> Run:
    """Only what `keep` says of each stream's times."""
    joints, readings = run.joints, run.readings
    j, r = (np.asarray(keep(one.time)) for one in (joints, readings))
    return replace(
        run,
        joints=JointSamples(joints.time[j], joints.names, joints.position[j], None),
        readings=Readings(
            readings.time[r], readings.names, readings.value[r], readings.status[r],
            readings.sequence[r], readings.temperature[r],
        ),
    )  # fmt: skip


def resampled(run: Run, rate: float, duration: float) -> Run:
    """The first so many seconds, linearly between the samples, at another rate [1/s]."""
    joints, readings = run.joints, run.readings
    time = np.arange(0.0, duration, 1.0 / rate)
    angles, values = (
        np.stack([np.interp(time, at, one) for one in values.T], axis=1)
        for at, values in ((joints.time, joints.position), (readings.time, readings.value))
    )
    shape = values.shape
    return replace(
        run,
        joints=JointSamples(time, joints.names, angles, None),
        readings=Readings(
            time, readings.names, values, np.zeros(shape, dtype=np.uint8),
            np.zeros(shape, dtype=np.int64), np.full(shape, np.nan),
        ),
    )  # fmt: skip
