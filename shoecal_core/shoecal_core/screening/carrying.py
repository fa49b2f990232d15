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
from shoecal_core.samples.walking import MAX_FOOT_SPEED, MAX_FOOT_TILT, World, in_world
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
        if run.info.support is not None or run.info.hanging or base is None or len(base.time) < 2:
            continue
        alone = carried_alone(shoe, one.readings)
        period = float(np.median(np.diff(one.time)))
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
    found = MovingFoot(_speed(world, alone), _tilt(world, alone), _share(world, alone))
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
    if found.speed > MAX_FOOT_SPEED and _speed(world, alone[:, ::-1]) < min(
        MAX_FOOT_SPEED, EXPLAINS * found.speed
    ):
        force, _ = vertical_forces(shoe, aligned.readings)
        upwards = float(np.median(force.sum(axis=1))) > 0.0
        return replace(found, exchanged=True, upwards=upwards)
    shifted, late_s = _shifted(aligned, base, world, alone, robot)
    if not shifted and found.speed <= MAX_FOOT_SPEED and found.tilt <= MAX_FOOT_TILT:
        # As a base pose that is not exact shows it, too.
        return None
    return replace(found, shifted=shifted, late_s=late_s)


def _shifted(
    aligned: Aligned, base: PoseSamples, world: World, alone: BoolArray, robot: Robot
) -> tuple[str, float]:
    """What is late, and by how much [s], if that explains how long feet move; else ""."""
    shifts, time = np.arange(STEP_S, LATEST_S, STEP_S), aligned.time
    tried: dict[tuple[str, float], tuple[float, float]] = {}
    for late in (*shifts.tolist(), *-shifts):
        moved = in_world(aligned, replace(base, time=base.time - late), robot)
        later = alone[np.clip(np.searchsorted(time, time + late), 0, len(time) - 1)]
        tried["the base pose", late] = _way(moved, alone)
        tried["the readings", late] = _way(world, later)
        # Joints that are late are early by as much for both of the others.
        tried["the joint angles", -late] = _way(moved, later)
    best = min(tried, key=lambda cause: tried[cause])
    return best if tried[best][1] < EXPLAINS * _share(world, alone) else ("", 0.0)


def _speed(world: World, alone: BoolArray) -> float:
    """Median speed of the foot that carries alone, the faster one's [m/s]."""
    speed = np.linalg.norm(world.sole_velocity, axis=-1)
    return max(float(np.median(speed[alone[:, foot], foot])) for foot in (0, 1))


def _share(world: World, alone: BoolArray) -> float:
    """Part of the time for which it moves."""
    moves = np.linalg.norm(world.sole_velocity, axis=-1) > MAX_FOOT_SPEED
    return max(float(np.mean(moves[alone[:, foot], foot])) for foot in (0, 1))


def _way(world: World, alone: BoolArray) -> tuple[float, float]:
    """How far feet move while they carry, over that time [m/s]; and the share of it."""
    speed = np.linalg.norm(world.sole_velocity, axis=-1)
    return float(np.mean(speed[alone])), _share(world, alone)


def _tilt(world: World, alone: BoolArray) -> float:
    """The same of how far it leans [rad]."""
    tilt = np.arccos(np.clip(world.sole_rotation[..., 2, 2], -1.0, 1.0))
    return max(float(np.median(tilt[alone[:, foot], foot])) for foot in (0, 1))
