"""In a walk, the foot that carries the robot stays where it is: base pose, joints and loads agree.

Found before any stance: with a base pose that is frozen, late or in another frame only a few
moments look like stances, and a fit to these few would be taken for one of the walk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.run import PoseSamples, Run
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import typical_period
from shoecal_core.samples.walking import MAX_FOOT_SPEED, MAX_FOOT_TILT, World, in_world
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import polarity_known, vertical_forces

LEAST_FORCE, MOST_FORCE = 0.8, 0.2
"""Of the range of its own force, what a foot that carries alone shows at least, and the other one
at most: no zero has to be known."""
LEAST_S = 1.0
"""A walk that shows a foot alone for less is not judged."""
FROZEN_M, FROZEN_RAD = 1e-3, 1e-3
"""A base that moves by less while a foot steps does not move."""
LATEST_S, STEP_S = 1.0, 0.05
"""Shifts between the clocks that are tried."""
MOST_MOVING = 0.1
"""Part of the time for which the foot that carries alone may move: it is 0.01 in three walks of a
REEM-C, 0.16 to 0.28 where readings are 0.3 s late or early, and 0.05 or less with 0.1 s."""
EXPLAINS = 0.25
"""Of that part, which a cause leaves at most."""


@dataclass(frozen=True)
class MovingFoot:
    """The foot that carries the robot moves, or leans, for most of the time that it carries.

    Attributes:
        speed: median over that time [m/s].
        tilt: the same [rad].
        frozen: the recorded base does not move.
        exchanged: the other foot stays instead.
        upwards: vertical forces of both feet are positive together.
        shifted: what is late, or early, where that explains it: base pose, readings, or joints.
        late_s: by how much.
        share: of that time, for which it moves.
    """

    speed: float
    tilt: float
    share: float
    frozen: bool = False
    exchanged: bool = False
    upwards: bool = True
    shifted: str = ""
    late_s: float = 0.0


def carried_alone(shoe: Shoe, readings: FloatArray) -> BoolArray:
    """(T, 2) each foot carries the robot alone, by readings (T, n)."""
    force, _ = vertical_forces(shoe, readings)
    least, most = np.percentile(force, [5.0, 95.0], axis=0)
    share = (force - least) / np.maximum(most - least, 1e-12)
    alone: BoolArray = (share > LEAST_FORCE) & (share[:, ::-1] < MOST_FORCE)
    return alone


def moving_feet(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned], shoe: Shoe, robot: Robot
) -> dict[int, MovingFoot]:
    """Walks in which the foot that carries the robot does not stay in the world, by number."""
    found: dict[int, MovingFoot] = {}
    if not polarity_known(shoe):
        return found
    for number, one in aligned.items():
        run = runs[number]
        base = run.base_pose
        if run.info.support is not None or base is None or len(base.time) < 2:
            continue
        alone = carried_alone(shoe, one.readings)
        period = typical_period(one.time)
        if np.any(alone.sum(axis=0) * period < LEAST_S):
            continue
        moving = _moving(one, base, alone, shoe, robot)
        if moving is not None:
            found[number] = moving
    return found


def _moving(
    aligned: Aligned, base: PoseSamples, alone: BoolArray, shoe: Shoe, robot: Robot
) -> MovingFoot | None:
    world = in_world(aligned, base, robot)
    speed = _speeds(world)
    found = MovingFoot(_usual(speed, alone), _tilt(world, alone), _share(speed, alone))
    if found.speed <= MAX_FOOT_SPEED and found.tilt <= MAX_FOOT_TILT and found.share <= MOST_MOVING:
        return None
    turns = np.abs(base.quaternion @ base.quaternion[0]).min()
    if (
        np.ptp(base.position, axis=0).max() < FROZEN_M
        and 2.0 * np.arccos(min(1.0, float(turns))) < FROZEN_RAD
    ):
        return replace(found, frozen=True)
    if found.speed <= MAX_FOOT_SPEED and found.share <= MOST_MOVING:
        return found
    if found.speed > MAX_FOOT_SPEED and _usual(speed, alone[:, ::-1]) < min(
        MAX_FOOT_SPEED, EXPLAINS * found.speed
    ):
        force, _ = vertical_forces(shoe, aligned.readings)
        upwards = float(np.median(force.sum(axis=1))) > 0.0
        return replace(found, exchanged=True, upwards=upwards)
    shifted, late_s = _shifted(aligned, base, speed, alone, robot)
    if not shifted and found.speed <= MAX_FOOT_SPEED and found.tilt <= MAX_FOOT_TILT:
        # As a base pose that is not exact shows it, too.
        return None
    return replace(found, shifted=shifted, late_s=late_s)


def _shifted(
    aligned: Aligned, base: PoseSamples, speed: FloatArray, alone: BoolArray, robot: Robot
) -> tuple[str, float]:
    """What is late, and by how much [s], if that explains how long feet move; else "".

    Args:
        speed: (T, 2) of the soles as they are [m/s].
    """
    shifts, time = np.arange(STEP_S, LATEST_S, STEP_S), aligned.time
    tried: dict[tuple[str, float], tuple[float, float]] = {}
    for late in (*shifts.tolist(), *-shifts):
        moved = _speeds(in_world(aligned, replace(base, time=base.time - late), robot))
        later = alone[np.clip(np.searchsorted(time, time + late), 0, len(time) - 1)]
        tried["the base pose", late] = _way(moved, alone)
        tried["the readings", late] = _way(speed, later)
        # Joints that are late are early by as much for both of the others.
        tried["the joint angles", -late] = _way(moved, later)
    best = min(tried, key=lambda cause: tried[cause])
    return best if tried[best][1] < EXPLAINS * _share(speed, alone) else ("", 0.0)


def _speeds(world: World) -> FloatArray:
    """(T, 2) of the soles [m/s]."""
    speed: FloatArray = np.linalg.norm(world.sole_velocity, axis=-1)
    return speed


def _usual(speed: FloatArray, alone: BoolArray) -> float:
    """Median speed of the foot that carries alone, the faster one's [m/s]."""
    return max(float(np.median(speed[alone[:, foot], foot])) for foot in (0, 1))


def _share(speed: FloatArray, alone: BoolArray) -> float:
    """Part of that time for which it moves, of the foot that does so for longer."""
    moves = speed > MAX_FOOT_SPEED
    return max(float(np.mean(moves[alone[:, foot], foot])) for foot in (0, 1))


def _way(speed: FloatArray, alone: BoolArray) -> tuple[float, float]:
    """Mean speed of feet that carry alone [m/s], and the share of time for which they move."""
    return float(np.mean(speed[alone])), _share(speed, alone)


def _tilt(world: World, alone: BoolArray) -> float:
    """Median of how far the foot that carries alone leans, of the one that leans more [rad]."""
    tilt = np.arccos(np.clip(world.sole_rotation[..., 2, 2], -1.0, 1.0))
    return max(float(np.median(tilt[alone[:, foot], foot])) for foot in (0, 1))


def describe_moving_feet(found: Mapping[int, MovingFoot]) -> list[Finding]:
    """Walks in which the foot that carries does not stay; those of one cause together."""
    runs: dict[str, list[int]] = {}
    for number, one in sorted(found.items()):
        runs.setdefault(_why_it_moves(one), []).append(number)
    findings = []
    for why, numbers in runs.items():
        speed = max(found[number].speed for number in numbers)
        tilt = max(found[number].tilt for number in numbers)
        share = max(found[number].share for number in numbers)
        text = (
            f"{name_runs(numbers)}: by base pose and joint angles the foot that carries the robot "
            f"alone moves for {share:.0%} of that time, by {speed:.2f} m/s, and leans by "
            f"{np.degrees(tilt):.0f} degrees (medians; it should stand still and flat): {why}"
        )
        fault = Fault.SWAPPED if found[numbers[0]].exchanged else Fault.BASE_POSE
        findings.append(Finding("FAIL", text, fault))
    return findings


def _why_it_moves(one: MovingFoot) -> str:
    """The cause of a foot that moves while it carries, and the cure."""
    if one.frozen:
        return (
            "the recorded base pose never changes; record the pose that the state estimator or "
            "motion capture gives while the robot walks"
        )
    if one.exchanged and one.upwards:
        return (
            "the other foot does instead, so left and right are exchanged; exchange their plugs, "
            "their topics, or feet.*.link in the robot file, and record again"
        )
    if one.exchanged:
        return (
            "the other foot does instead, and forces are negative, so both vertical forces are "
            "inverted; turn their 'polarity' in the shoe file round"
        )
    if one.shifted:
        return (
            f"it would with {one.shifted} {1e3 * abs(one.late_s):.0f} ms "
            f"{'earlier' if one.late_s > 0.0 else 'later'}; let base pose, joints and readings be "
            "stamped when they are sampled, by one clock"
        )
    return (
        "check the base pose (that it is the pose of the URDF's root link in a frame with z up, in "
        "m, its angles' order and unit), then signs and zeros of the leg joints"
    )
