"""Joint angles and readings of a run at the same instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.align import interpolate_joints
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.joint_series import beyond_limits, in_degrees
from shoecal_core.recording.packets import ANGLES_S, READINGS_S, find_packets
from shoecal_core.recording.run import Run
from shoecal_core.recording.schemas import GOOD, JOINT_STATES
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

MAX_JOINT_GAP_S = 0.1
"""Readings between joint angles further apart than this have no model value."""
LEAST_HZ = 10.0
"""Of readings: the slower rate of common converters, with which a run of 10 s has enough."""
MIN_SAMPLES = 50
JUMP_RAD, JUMP_SPEEDS = 0.1, 3.0
"""Between two samples a joint jumps that moves by more than both: this, and so many times as fast
as its motor can."""
JUMPS_SHARE = 0.05
"""Of its samples at which a joint may jump; encoders fail now and then."""


@dataclass(frozen=True)
class Aligned:
    """Readings and body states at the same T instants.

    Attributes:
        time: (T,) since the run's start [s].
        readings: (T, n) raw, all finite.
        joint_angles: (T, m) of the whole robot [rad].
        states: what the joint angles say.
        late_s: the robot's stamps were late by this much against `time` [s].
    """

    time: FloatArray
    readings: FloatArray
    joint_angles: FloatArray
    states: BodyStates
    late_s: float = 0.0

    def part(self, part: BoolArray) -> Aligned:
        """The samples marked in `part` (T,)."""
        return Aligned(
            self.time[part],
            self.readings[part],
            self.joint_angles[part],
            self.states.part(part),
            self.late_s,
        )


def align(run: Run, shoe: Shoe, kinematics: Kinematics, *, late_s: float = 0.0) -> Aligned:
    """Joint angles interpolated to the readings; what has no partner is left out.

    Args:
        run: recorded.
        shoe, kinematics: of what was recorded.
        late_s: joint stamps are late by this much against those of the readings [s].

    Raises:
        JointsMissingError: the run's joints are not the robot's.
        RecordingError: too little remains, angles are in degrees or those of two senders, or either
            is stamped packet by packet.
    """
    good = np.isfinite(run.readings.value).all(axis=1) & (run.readings.status == GOOD).all(axis=1)
    time = run.readings.time[good]
    names = recorded_joints(run, kinematics.robot)
    _check_unit(run, names, kinematics.robot)
    _check_jumps(run, names, kinematics.robot)
    _check_packets(run, names)
    _check_rate(run, names)
    measured, covered = interpolate_joints(
        run.joints, time, MAX_JOINT_GAP_S, late_s=late_s, names=names
    )
    angles = kinematics.robot.from_measured(names, measured)
    if covered.sum() < MIN_SAMPLES:
        raise RecordingError(
            run.path,
            f"only {int(covered.sum())} samples have both good readings of all {len(shoe.names)} "
            f"channels and joint angles; {_cure(run, names)}",
        )
    angles = angles[covered]
    readings = run.readings.value[good][covered]
    return Aligned(time[covered], readings, angles, kinematics.states(angles), late_s)


def _check_unit(run: Run, names: list[str], robot: Robot) -> None:
    """Refuse angles in degrees."""
    for name in names:
        joint, position = robot.joint(name), _angles(run, name)
        limits = robot.lower[joint], robot.upper[joint]
        if len(position) and in_degrees(position, *limits):
            raise RecordingError(
                run.path,
                f"{beyond_limits(name, position, *limits)}, but within them in degrees; record "
                "them in rad, or import them with 'angle_unit: deg'",
                field=JOINT_STATES,
            )


def _angles(run: Run, name: str) -> FloatArray:
    """(k,) angles of a joint, of where it has some [rad]."""
    position = run.joints.position[:, run.joints.names.index(name)]
    return position[np.isfinite(position)]


def _check_jumps(run: Run, names: list[str], robot: Robot) -> None:
    """Refuse angles that jump to and fro: two senders that take turns."""
    limits = dict(zip(robot.joint_names, robot.velocity_limit, strict=True))
    for name in names:
        position = run.joints.position[:, run.joints.names.index(name)]
        known = np.isfinite(position)
        step, period = np.diff(position[known]), np.diff(run.joints.time[known])
        allowed = np.maximum(JUMP_RAD, JUMP_SPEEDS * limits[name] * period)
        jumps = np.abs(step) > allowed
        if limits[name] > 0.0 and len(step) and jumps.mean() > JUMPS_SHARE:
            raise RecordingError(
                run.path,
                f"'{name}' jumps to and fro by {np.median(np.abs(step[jumps])):.2f} rad within "
                f"{1e3 * np.median(period[jumps]):.0f} ms, faster than its motor can: two senders "
                "take turns, or encoders fail; record it from one source",
                field=JOINT_STATES,
            )


def _check_packets(run: Run, names: list[str]) -> None:
    """Refuse readings or angles whose stamps are those of their receipt in packets."""
    angles = [run.joints.position[:, run.joints.names.index(name)] for name in names]
    for what, time, columns, bearable in (
        ("readings", run.readings.time, list(run.readings.value.T), READINGS_S),
        ("joint angles", run.joints.time, angles, ANGLES_S),
    ):
        for known in {np.isfinite(one).tobytes(): np.isfinite(one) for one in columns}.values():
            if (packets := find_packets(time[known], bearable)) is not None:
                raise RecordingError(run.path, packets.describe(what))


def _check_rate(run: Run, names: list[str]) -> None:
    """Refuse angles that come so seldom that there are none between them."""
    for name in names:
        known = np.isfinite(run.joints.position[:, run.joints.names.index(name)])
        periods = np.diff(run.joints.time[known])
        if len(periods) and (usual := float(np.median(periods))) > MAX_JOINT_GAP_S:
            raise RecordingError(
                run.path,
                f"angles of '{name}' come {1.0 / usual:.3g} times a second; at times further apart "
                f"than {MAX_JOINT_GAP_S:g} s nothing is known between them: let the robot's driver "
                f"publish them {1.0 / MAX_JOINT_GAP_S:g} times a second or more, and record again",
                field=JOINT_STATES,
            )


def _cure(run: Run, names: list[str]) -> str:
    """What to look at: joints without angles, channels that hardly read well, else the clocks."""
    if absent := [name for name in names if not len(_angles(run, name))]:
        return (
            f"there is no angle of {', '.join(absent)}: record it, or list it under "
            "'optional_joints' of the robot file if it stands still"
        )
    readings = run.readings
    if absent := list(np.array(readings.names)[~np.isfinite(readings.value).any(axis=0)]):
        return f"there is no reading of {', '.join(absent)}: record the topic that has them"
    bad = ~np.isfinite(readings.value) | (readings.status != GOOD)
    silent = np.array(readings.names)[bad.mean(axis=0) > 0.5]
    if len(silent):
        return f"{', '.join(silent)} gave none or bad ones most of the time: check its cable"
    if readings.rate_hz < LEAST_HZ:
        return (
            f"readings come {readings.rate_hz:.1f} times a second: set the board to "
            f"{LEAST_HZ:g} times or more (HX711: its RATE pin)"
        )
    return "check that both were recorded, with stamps of one clock"


def recorded_joints(run: Run, robot: Robot) -> list[str]:
    """The robot's joints that were recorded; some drivers send NaN for optional ones."""
    known = np.asarray(np.isfinite(run.joints.position).any(axis=0))
    return [
        name
        for name, is_known in zip(run.joints.names, known.tolist(), strict=True)
        if name in robot.joint_names and (is_known or name not in robot.optional)
    ]
