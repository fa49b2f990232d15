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
EXPLAINS = 0.25
"""Of the speed, that a cause leaves at most."""


@dataclass(frozen=True)
class MovingFoot:
    """The foot that carries the robot moves, or leans, for most of the time that it carries.

    Attributes:
        speed: median over that time [m/s].
        tilt: the same [rad].
        frozen: the recorded base does not move.
        exchanged: the other foot stays instead.
        upwards: vertical forces of both feet are positive together.
        late_s: by which the base pose is late, or early, where that explains it; 0: it does not.
    """

    speed: float
    tilt: float
    frozen: bool = False
    exchanged: bool = False
    upwards: bool = True
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
    speed, tilt = _speed(world, alone), _tilt(world, alone)
    if speed <= MAX_FOOT_SPEED and tilt <= MAX_FOOT_TILT:
        return None
    found = MovingFoot(speed, tilt)
    turns = np.abs(base.quaternion @ base.quaternion[0]).min()
    if (
        np.ptp(base.position, axis=0).max() < FROZEN_M
        and 2.0 * np.arccos(min(1.0, float(turns))) < FROZEN_RAD
    ):
        return replace(found, frozen=True)
    if speed <= MAX_FOOT_SPEED:
        return found
    least = min(MAX_FOOT_SPEED, EXPLAINS * speed)
    if _speed(world, alone[:, ::-1]) < least:
        force, _ = vertical_forces(shoe, aligned.readings)
        upwards = float(np.median(force.sum(axis=1))) > 0.0
        return replace(found, exchanged=True, upwards=upwards)
    shifts = np.arange(STEP_S, LATEST_S, STEP_S)
    tried = {
        float(late): _speed(in_world(aligned, replace(base, time=base.time - late), robot), alone)
        for late in (*shifts, *-shifts)
    }
    best = min(tried, key=lambda late: tried[late])
    return replace(found, late_s=best if tried[best] < least else 0.0)


def _speed(world: World, alone: BoolArray) -> float:
    """Median speed of the foot that carries alone, the faster one's [m/s]."""
    speed = np.linalg.norm(world.sole_velocity, axis=-1)
    return max(float(np.median(speed[alone[:, foot], foot])) for foot in (0, 1))


def _tilt(world: World, alone: BoolArray) -> float:
    """The same of how far it leans [rad]."""
    tilt = np.arccos(np.clip(world.sole_rotation[..., 2, 2], -1.0, 1.0))
    return max(float(np.median(tilt[alone[:, foot], foot])) for foot in (0, 1))
