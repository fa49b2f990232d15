"""What the floor does to the feet, from contact forces alone: the truth."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from shoecal_core.sensing.shoe import FEET
from shoecal_core.simulation.shoe_physics import sole_name

FloatArray = NDArray[np.float64]

MIN_LOAD = 0.5
"""N; with less on it a foot has no CoP."""


@dataclass(frozen=True)
class FloorTruth:
    """The floor's forces at one instant. Sole frames lie in the floor plane below the soles.

    Attributes:
        cop: (2,) CoP of both feet in the left sole's frame [m]; NaN where nothing is loaded.
        foot_cop: (2, 2) CoP of left, right, each in its own sole's frame [m]; NaN likewise.
        foot_force: (2, 3) force of the floor on left, right, each in its own sole's frame [N].
    """

    cop: FloatArray
    foot_cop: FloatArray
    foot_force: FloatArray

    @property
    def foot_grf(self) -> FloatArray:
        """(2,) vertical force on left, right [N]."""
        return self.foot_force[:, 2]

    @property
    def grf(self) -> float:
        """Vertical force on both feet [N]."""
        return float(self.foot_force[:, 2].sum())


class FloorProbe:
    """Reads the contact forces below the shoes."""

    def __init__(self, model: mujoco.MjModel, feet: tuple[int, ...] = (0, 1)) -> None:
        self._soles = [model.body(sole_name(foot)).id if foot in feet else 0 for foot in (0, 1)]
        self._foot = np.full(model.ngeom, -1)
        for foot in feet:
            self._foot[model.geom_bodyid == self._soles[foot]] = foot

    def __call__(self, data: mujoco.MjData) -> FloorTruth:
        """The truth at the instant of the last forward computation."""
        forces, moments = self._wrenches(data)
        place = np.array([data.xpos[sole][:2] for sole in self._soles])
        forward = np.array([data.xmat[sole].reshape(3, 3)[:2, 0] for sole in self._soles])
        forward /= np.linalg.norm(forward, axis=1, keepdims=True)
        # Rows are the sole frames' axes in the world.
        axes = np.stack((forward, np.stack((-forward[:, 1], forward[:, 0]), axis=1)), axis=1)
        cop = np.array([_cop(forces[foot], moments[foot]) for foot in (0, 1)])
        both = _cop(forces.sum(axis=0), moments.sum(axis=0))
        sideways = np.einsum("fij,fj->fi", axes, forces[:, :2])
        return FloorTruth(
            cop=axes[0] @ (both - place[0]),
            foot_cop=np.einsum("fij,fj->fi", axes, cop - place),
            foot_force=np.column_stack((sideways, forces[:, 2])),
        )

    def _wrenches(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
        """Force (2, 3) and moment (2, 3) about the world's origin on each foot."""
        contact = data.contact
        foot = self._foot[contact.geom[:, 1]]
        rows = contact.efc_address
        active = (rows >= 0) & (foot >= 0)
        foot, rows = foot[active], rows[active]
        # Elliptic cone: normal and two tangents; the frame's rows are those directions.
        local = data.efc_force[rows[:, None] + np.arange(3)]
        frame = contact.frame[active].reshape(-1, 3, 3)
        force = np.einsum("ci,cij->cj", local, frame)
        moment = np.cross(contact.pos[active], force)
        forces, moments = np.zeros((len(FEET), 3)), np.zeros((len(FEET), 3))
        np.add.at(forces, foot, force)
        np.add.at(moments, foot, moment)
        return forces, moments


def _cop(force: FloatArray, moment: FloatArray) -> FloatArray:
    """(2,) point of the plane z = 0 about which the force has no sideways moment."""
    if force[2] < MIN_LOAD:
        return np.full(2, np.nan)
    place: FloatArray = np.array([-moment[1], moment[0]]) / force[2]
    return place
