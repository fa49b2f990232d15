"""A foot that slips once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.disturbances import Disturbance, MovingRobot
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import read_feet, read_shift
from shoecal_core.simulation.shoe_physics import SoleReader, sole_name, tip_geoms

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


_ICE = 0.02
"""Friction below a foot while it slips."""
_MOVED, DURATION = 0.3, 1.2
"""s, since a slip's beginning: moved until, loose until."""
_CORRECTED = 0.05
"""Share of what is missing that servos aim further, in each of their periods."""


@dataclass(frozen=True)
class Slip(Effect):
    """Feet that slip once, in one run, to where their legs would have them.

    Servos hold the joints, not the feet: a foot glides when its leg is strained by a stance that
    the feet do not have, and stays where that strain is gone. So from a moment on the servos aim
    at the stance that the slip leads to, and the foot loses its grip until it is there. What was
    commanded knows nothing of it, encoders do.

    Attributes:
        feet: which ones.
        shift: (dx, dy, dtheta) in the sole frame before [m, m, rad].
        time: since that run's start [s].
        run: of the session, from 1.
    """

    feet: tuple[str, ...]
    shift: tuple[float, float, float]
    time: float
    run: int

    @classmethod
    def read(cls, fields: Fields) -> Slip:
        """From the item of a reality file."""
        fields.only("effect", "location", "dx_m", "dy_m", "dtheta_rad", "time_s", "run")
        return cls(
            read_feet(fields),
            read_shift(fields),
            fields.number("time_s", minimum=0.0),
            fields.integer("run", minimum=1),
        )

    def disturbances(self) -> Sequence[Disturbance]:
        """Each foot's slip."""
        return [_Slipping(self, foot) for foot in map(FEET.index, self.feet)]


@dataclass
class _Slipping:
    """One foot of one robot."""

    slip: Slip
    foot: int
    _stance: Restancing | None = field(default=None, init=False)
    _correction: FloatArray = field(default_factory=lambda: np.zeros(3), init=False)

    def act(self, sim: MovingRobot, time: float) -> None:
        """Loosen, strain the legs, and grip again."""
        since = time - self.slip.time if sim.run == self.slip.run else -1.0
        if since < 0.0:
            if self._stance is not None:
                self._grip(sim, loose=False)
            self._stance = None
            return
        if self._stance is None:
            self._stance, self._correction = Restancing(sim.physics, self.foot), np.zeros(3)
        self._grip(sim, loose=since < DURATION)
        # Gently at both ends: a jerk would throw the robot.
        way = 0.5 - 0.5 * math.cos(math.pi * min(1.0, since / _MOVED))
        wanted = way * np.array(self.slip.shift)
        if since < DURATION:
            # Gears give, and legs were strained before: the foot is to come where it is said to.
            self._correction += _CORRECTED * (wanted - self._stance.moved(sim.data))
        sim.strain += self._stance(sim.data.act, wanted + self._correction)

    def _grip(self, sim: MovingRobot, *, loose: bool) -> None:
        model = sim.physics.model
        tips = tip_geoms(model, self.foot)
        # With priority the tips' own friction counts, not the floor's.
        model.geom_priority[tips] = int(loose)
        model.geom_friction[tips, 0] = _ICE if loose else model.geom("floor").friction[0]


EFFECTS: dict[str, Callable[[Fields], Effect]] = {"slip": Slip.read}
"""Effects of this family by identifier."""
