"""Where a robot's joints are, on their axes: files put a joint's frame anywhere along its axis."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.symbolic import joint_axis
from shoecal_core.robot.urdf import ROOT_JOINTS

LEAST_SINE = 0.1
"""Axes with a smaller sine of the angle between them count as parallel."""


def axis_of(model: pin.Model, placements: Sequence[pin.SE3], joint: int) -> FloatArray:
    """(3,) unit axis about which a joint turns, in the base.

    Args:
        model: of the robot.
        placements: of every joint of the model, in the base.
        joint: of the model.
    """
    linear, angular = joint_axis(model, joint)
    axis = placements[joint].rotation @ (linear + angular)
    return np.asarray(axis / np.linalg.norm(axis))


def centres_of(model: pin.Model, placements: Sequence[pin.SE3]) -> tuple[FloatArray, ...]:
    """Of every joint the point of its axis that is nearest to the joint before it.

    Of a limb's first joint it is the one nearest to the axis of the next that is not parallel.

    Args:
        model: of the robot.
        placements: of every joint of the model, in the base.

    Returns:
        (3,) of every joint, in the base [m].
    """
    found = [np.asarray(placement.translation, dtype=np.float64) for placement in placements]
    for joint in own_joints(model):
        if not joint_axis(model, joint)[1].any():
            continue  # a slide has no axis in any place
        axis, before = axis_of(model, placements, joint), int(model.parents[joint])
        if before in own_joints(model):
            found[joint] = found[joint] + axis * (axis @ (found[before] - found[joint]))
            continue
        after = _only_child(model, joint)
        while after is not None:
            other = axis_of(model, placements, after)
            normal = np.cross(axis, other)
            if (square := float(normal @ normal)) > LEAST_SINE**2:
                way = np.cross(found[after] - found[joint], other) @ normal / square
                found[joint] = found[joint] + axis * way
                break
            after = _only_child(model, after)
    return tuple(found)


def leg_length(centres: Sequence[FloatArray], leg: Sequence[int]) -> float:
    """From joint to joint [m].

    Args:
        centres: (3,) of every joint of the model. leg: joints from the hip to the foot.
    """
    return float(sum(np.linalg.norm(centres[b] - centres[a]) for a, b in pairwise(leg)))


def _only_child(model: pin.Model, joint: int) -> int | None:
    children = [one for one in own_joints(model) if int(model.parents[one]) == joint]
    return children[0] if len(children) == 1 else None


def own_joints(model: pin.Model) -> range:
    """The robot's joints, without those of the base."""
    return range(ROOT_JOINTS, model.njoints)
