"""What the floor does to the feet, from contact forces alone: the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.shoe.wrench import cop

MIN_LOAD = 0.5
"""N; with less on it a foot has no CoP."""


@dataclass(frozen=True)
class FloorTruth:
    """The floor's forces at one instant or many (...). Sole frames lie in the floor's plane.

    Attributes:
        cop: (..., 2) CoP of both feet in the left sole's frame [m]; NaN where nothing is loaded.
        foot_cop: (..., 2, 2) CoP of left, right, each in its own sole's frame [m]; NaN likewise.
        foot_force: (..., 2, 3) the floor's force on left, right, each in its own sole's frame [N].
    """

    cop: FloatArray
    foot_cop: FloatArray
    foot_force: FloatArray

    @property
    def foot_grf(self) -> FloatArray:
        """(..., 2) vertical force on left, right [N]."""
        return self.foot_force[..., 2]

    @property
    def grf(self) -> FloatArray:
        """(...) vertical force on both feet [N]."""
        total: FloatArray = self.foot_force[..., 2].sum(axis=-1)
        return total


def floor_truth(contact: FloatArray, position: FloatArray, rotation: FloatArray) -> FloorTruth:
    """The truth from net contact wrenches.

    Args:
        contact: (..., 2, 9) of the contacts below left, right: force [N], torque [N m], and the
            place where they act [m], in the floor's frame.
        position: (..., 2, 3) origins of the true sole frames in the floor's frame [m].
        rotation: (..., 2, 3, 3) of the true sole frames.
    """
    force, torque, place = contact[..., :3], contact[..., 3:6], contact[..., 6:]
    moment = torque + np.cross(place, force)
    axes = _sole_axes(rotation)
    wrench = np.concatenate((force[..., 2:], moment[..., :2]), axis=-1)
    both = cop(wrench.sum(axis=-2), MIN_LOAD) - position[..., 0, :2]
    each = cop(wrench, MIN_LOAD) - position[..., :2]
    sideways = _turned(axes, force[..., :2])
    return FloorTruth(
        cop=_turned(axes[..., 0, :, :], both),
        foot_cop=_turned(axes, each),
        foot_force=np.concatenate((sideways, force[..., 2:]), axis=-1),
    )


def sideways_forces(force: FloatArray, rotation: FloatArray) -> FloatArray:
    """(..., 2, 2) the floor's force on left, right along x and y of its sole frame [N].

    Args:
        force: (..., 2, 3) net force of the contacts below left, right, in the floor's frame [N].
        rotation: (..., 2, 3, 3) of the true sole frames.
    """
    return _turned(_sole_axes(rotation), force[..., :2])


def _sole_axes(rotation: FloatArray) -> FloatArray:
    """(..., 2, 2) rows: x and y of sole frames with these rotations, in the floor's plane."""
    forward = rotation[..., :2, 0]
    forward = forward / np.linalg.norm(forward, axis=-1, keepdims=True)
    leftward = np.stack((-forward[..., 1], forward[..., 0]), axis=-1)
    return np.stack((forward, leftward), axis=-2)


def _turned(axes: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 2) along axes (..., 2, 2)."""
    turned: FloatArray = (axes @ vectors[..., None])[..., 0]
    return turned
