"""When a foot of a standing robot is in the air: by the soles' heights, and by purpose and load.

A foot in the air carries nothing, which fixes its offsets, and the other one carries the whole
weight alone. So a run that lifts one on purpose is cut into stances: before, in the air, and after,
when the foot may stand a little elsewhere. What lies between counts for nothing. Where feet walk,
`contact` finds those in the air.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.level import standing_pose
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.contact import moves
from shoecal_core.samples.stretches import lasting, unchanged, widened
from shoecal_core.shoe.shoe import Shoe

UNLOADING: Mapping[str, int] = {"unload_left": 0, "unload_right": 1}
"""Motions that lift a foot, by name: index of the foot."""
LIFT_M, LIFT_RAD = 0.003, 0.03
"""A foot that is this much higher or more tilted than while both stand does not stand."""
TRANSIT_S = 0.8
"""Around lifting and landing, samples are left out for this long."""
GIVE_M = 0.01
"""Gears that give and have play lift a standing foot by less, as its joints have it."""
STANDS_SHARE = 0.1
"""A foot that carries more of the weight is not in the air: gains and offsets that are roughly
known tell it from one that carries nothing."""
BOTH_STAND, NEITHER = -1, -2
"""In place of a foot's index: none hangs; or one may hang, stand on an edge, or elsewhere."""
FREE_SHARE = 0.6
"""A foot hangs free above this share of the height that it is lifted to: gears that give make
that height a little less than it seems."""
LEAST_AIR_S = 0.5
"""A foot that is up for a shorter time does not hang still."""


@dataclass(frozen=True)
class LiftedFoot:
    """A run in which one foot is lifted.

    Attributes:
        foot: index of it.
        air: (T,) it hangs free.
        moving: (T,) it is neither free nor firmly on the floor.
    """

    foot: int
    air: BoolArray
    moving: BoolArray

    def stretches(self) -> list[BoolArray]:
        """(T,) masks of each part between changes of what carries, `moving` left out."""
        changes = np.flatnonzero(np.diff(self.air.astype(np.int8)) != 0) + 1
        edges = [0, *changes.tolist(), len(self.air)]
        parts = []
        for first, end in pairwise(edges):
            mask = np.zeros(len(self.air), dtype=bool)
            mask[first:end] = ~self.moving[first:end]
            parts.append(mask)
        return parts


def height_change(states: BodyStates) -> FloatArray:
    """(T,) by how much one foot is higher or lower against the other than while both stand [m]."""
    change: FloatArray = np.abs(states.translation[:, 2] - standing_pose(states)[0])
    return change


def lifted(states: BodyStates) -> BoolArray:
    """(T,) one foot is in the air or on an edge."""
    off = np.abs(states.right_sole[:, 2:5] - standing_pose(states))
    high: BoolArray = np.any(off > (LIFT_M, LIFT_RAD, LIFT_RAD), axis=1)
    return high


def hanging_foot(
    aligned: Aligned, air: BoolArray, robot: Robot, shoe: Shoe, load: FloatArray | None = None
) -> IntArray:
    """(T,) index of the foot that hangs, BOTH_STAND, or NEITHER where that is not known.

    It is the one farther from the CoM. One that carries load while it is highest, or whose load
    changes, is not in the air: gears that give and soft floors make a foot that stands look lifted.
    One that landed where joints still lift it stands on an edge, or elsewhere.

    Args:
        aligned: T samples.
        air: (T,) one foot is in the air, by the joints.
        robot, shoe: of what was recorded.
        load: (T, 2) what each foot carries as a share of the weight, where that is known.
    """
    com = aligned.states.com[:, :, :2]
    away = [
        np.linalg.norm(com[:, foot] - one.outline.mean(axis=0), axis=1)
        for foot, one in enumerate(robot.feet)
    ]
    hanging = np.where(air, np.where(away[0] < away[1], 1, 0), BOTH_STAND)
    height = height_change(aligned.states)
    for part in unchanged(hanging):
        foot = int(hanging[part[0]])
        if foot < 0:
            continue
        top = float(height[part].max())
        free = part[height[part] > FREE_SHARE * top]
        if load is not None:
            carries = load[:, foot] > STANDS_SHARE
            if carries[free].mean() <= 0.5:
                hanging[part[carries[part]]] = NEITHER
                free = free[~carries[free]]
            elif top < GIVE_M:
                hanging[part] = BOTH_STAND
                continue
        if moves(shoe, aligned.readings, free, foot):
            hanging[part] = BOTH_STAND if load is None or top < GIVE_M else NEITHER
    return hanging


def detect_lifted_foot(motion: str, aligned: Aligned) -> LiftedFoot | None:
    """When the foot that a motion lifts is in the air; None where it lifts none.

    Args:
        motion: name on the catalogue of motions.
        aligned: T samples of the run.
    """
    if motion not in UNLOADING:
        return None
    time = aligned.time
    up = lifted(aligned.states)
    height = aligned.states.translation[:, 2]
    height = np.abs(height - np.median(height[~up])) if not up.all() else height
    high = up & (height > FREE_SHARE * height.max())
    inner = ~widened(~high, time, TRANSIT_S)
    air = lasting(inner, time, LEAST_AIR_S)
    return LiftedFoot(UNLOADING[motion], air, widened(up, time, TRANSIT_S) & ~air)
