"""What legs have to do so that their feet stand elsewhere to each other."""

from __future__ import annotations

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.shoe_physics import SoleReader, sole_name

_STEPS = 3
"""Of Newton's, each time: begun where the last one ended, that is more than enough."""


class Restancing:
    """Joint angles in which one sole stands elsewhere to the other: inverse kinematics.

    The sole moves in its own plane; motors share the change as evenly as can be.
    """

    def __init__(self, physics: RobotPhysics, foot: int) -> None:
        self._physics, self._foot = physics, foot
        self._scratch = mujoco.MjData(physics.model)
        self._soles = SoleReader(physics.model)
        self._bodies = [physics.model.body(sole_name(one)).id for one in (0, 1)]
        self._dofs = physics.model.jnt_dofadr[
            [int(np.flatnonzero(physics.model.jnt_qposadr == at)[0]) for at in physics.positions]
        ]
        self._change = np.zeros(physics.model.nu)
        self._before: tuple[FloatArray, FloatArray] | None = None

    def __call__(self, aims: FloatArray, shift: FloatArray) -> FloatArray:
        """What is to be added to the motors' angles.

        Args:
            aims: (a,) where the servos aim now, with what was last answered [rad].
            shift: (dx, dy, dtheta) of the sole in its own frame [m, m, rad].

        Returns:
            (a,) [rad].
        """
        base = aims - self._change
        position, rotation = self._relative(base)
        c, s = np.cos(shift[2]), np.sin(shift[2])
        goal = position + rotation @ np.array([shift[0], shift[1], 0.0])
        turned = rotation @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        for _ in range(_STEPS):
            position, rotation = self._relative(base + self._change)
            rest = np.concatenate((goal - position, _rotation_vector(turned @ rotation.T)))
            self._change = self._change + np.linalg.lstsq(self._jacobian(), rest, rcond=1e-6)[0]
        return self._change.copy()

    def moved(self, data: mujoco.MjData) -> FloatArray:
        """(3,) how far the sole has moved since this was first asked [m, m, rad]."""
        position, rotation = self._between(data)
        if self._before is None:
            self._before = position, rotation
        was, turned = self._before
        way = turned.T @ (position - was)
        return np.array([way[0], way[1], _rotation_vector(turned.T @ rotation)[2]])

    def _relative(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Place and rotation of the sole in the other one's frame, at motors' angles (a,)."""
        physics = self._physics
        self._scratch.qpos[physics.positions] = angles[physics.motor] * physics.ratio
        mujoco.mj_kinematics(physics.model, self._scratch)
        mujoco.mj_comPos(physics.model, self._scratch)
        return self._between(self._scratch)

    def _between(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
        position, rotation = self._soles.pose(data)
        base = rotation[1 - self._foot].T
        return base @ (position[self._foot] - position[1 - self._foot]), base @ rotation[self._foot]

    def _jacobian(self) -> FloatArray:
        """(6, a) of that pose by the motors' angles, at the angles last looked at."""
        model, data, physics = self._physics.model, self._scratch, self._physics
        position, rotation = self._soles.pose(data)
        ours, theirs = self._foot, 1 - self._foot
        both = np.zeros((2, 6, model.nv))
        # Of the same point, as if it were fixed to either sole.
        for one in (ours, theirs):
            mujoco.mj_jac(model, data, both[one, :3], both[one, 3:], position[ours],
                          self._bodies[one])  # fmt: skip
        moves = both[ours] - both[theirs]
        base = rotation[theirs].T
        turned = np.concatenate((base @ moves[:3], base @ moves[3:]))[:, self._dofs]
        found = np.zeros((6, model.nu))
        np.add.at(found.T, physics.motor, (turned * physics.ratio).T)
        return found


def _rotation_vector(rotation: FloatArray) -> FloatArray:
    """(3,) of a small rotation (3, 3) [rad]."""
    away = rotation - rotation.T
    return 0.5 * np.array([away[2, 1], away[0, 2], away[1, 0]])
