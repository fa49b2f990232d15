"""How high and how tilted one sole is against the other while both feet stand."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.robot.kinematics import BodyStates

LEVEL_M, LEVEL_RAD = 0.01, 0.05
"""Soles that stand on one floor differ by less, as joints with play, sag and zeros a little off
have it."""
LEVEL_SHARE = 0.1
"""Of all samples, from which level soles are those of standing feet and not of a foot on its way
through."""


def level(states: BodyStates) -> BoolArray:
    """(T,) both soles may be on one floor."""
    off = np.abs(states.right_sole[:, 2:5])
    there: BoolArray = np.all(off <= (LEVEL_M, LEVEL_RAD, LEVEL_RAD), axis=1)
    return there


def standing_samples(states: BodyStates) -> BoolArray:
    """(T,) soles that are level; all samples where joint errors leave hardly any."""
    there = level(states)
    return there if there.mean() >= LEVEL_SHARE else np.ones(len(there), dtype=bool)


def standing_pose(states: BodyStates) -> FloatArray:
    """(3,) height [m] and tilts about x and y [rad] of the right sole in the left one's frame while
    both feet stand, however long one of them is in the air.
    """
    pose: FloatArray = np.median(states.right_sole[standing_samples(states), 2:5], axis=0)
    return pose
