"""A foot that slips once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from shoecal_core.files import Fields
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import FEET
from shoecal_core.simulation.disturbances import Disturbance
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import read_feet, read_shift
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.shoe_physics import sole_name, tip_geoms

FloatArray = NDArray[np.float64]

_LEVER, _REACH = 0.2, 1.0
"""m; arm of the spring that turns, and length of all: far longer than any slip, so that each
pulls along one axis."""
_POINTS = np.array([[0.0, 0.0], [0.0, 0.0], [_LEVER, 0.0]])
_WAYS = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
"""Where on the sole the springs pull, and which way, in its frame."""
_STIFFNESS, _DAMPING_TIME = 1e6, 0.005
"""N/m; s, damping over stiffness."""
_ICE = 0.02
"""Friction below a foot while it slips."""
_CAUGHT = 4.0
"""The same, once it has come to rest: it has caught on something, so that legs that were strained
by the slip do not pull it back."""
_DRAWN, DURATION, _HELD, _FREE = 0.3, 0.35, 0.4, 0.7
"""s, since a slip's beginning: drawn along until, loose until, held until, and free again."""


@dataclass(frozen=True)
class Slip(Effect):
    """Feet that slip once, in one run: they lose their grip and are drawn along by springs.

    They grip again before the springs fade, and hold fast until the next run.

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

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:  # noqa: ARG002
        """Springs between soles and room that do not pull yet."""
        for foot in map(FEET.index, self.feet):
            sole = spec.body(sole_name(foot))
            for name, point in zip(self._springs(foot), _POINTS, strict=True):
                sole.add_site(name=name, pos=[*point, 0.0])
                spec.worldbody.add_site(name=f"{name}/room", pos=[_REACH, 0.0, 0.0])
                spring = spec.add_tendon(name=name, springlength=[_REACH, _REACH])
                spring.wrap_site(name)
                spring.wrap_site(f"{name}/room")

    def disturbances(self) -> Sequence[Disturbance]:
        """Each foot's slip."""
        return [_Slipping(self, foot, self._springs(foot)) for foot in map(FEET.index, self.feet)]

    def _springs(self, foot: int) -> list[str]:
        place = f"slip/{self.run}/{self.time:g}/{FEET[foot]}"
        return [f"{place}/{name}" for name in ("along", "aside", "turn")]


@dataclass
class _Slipping:
    """One foot of one robot."""

    slip: Slip
    foot: int
    springs: Sequence[str]
    _ways: FloatArray | None = field(default=None, init=False)

    def act(self, sim: SimulatedRobot, time: float) -> None:
        """Loosen and draw along, grip and let go."""
        since = time - self.slip.time if sim.run == self.slip.run else -1.0
        if since < 0.0 and self._ways is None:
            return
        model = sim.physics.model
        tips = tip_geoms(model, self.foot)
        friction = _ICE if since < DURATION else _CAUGHT
        # With priority the tips' own friction counts, not the floor's.
        model.geom_priority[tips] = int(since >= 0.0)
        model.geom_friction[tips, 0] = friction if since >= 0.0 else sim.drawn.rules.floor.friction
        tendons = [model.tendon(name).id for name in self.springs]
        left = (_FREE - since) / (_FREE - _HELD)
        stiffness = _STIFFNESS * float(np.clip(left, 0.0, 1.0)) * (since >= 0.0)
        model.tendon_stiffness[tendons] = stiffness
        model.tendon_damping[tendons] = stiffness * _DAMPING_TIME
        if since < 0.0:
            self._ways = None
            return
        if self._ways is None:
            self._ways = self._stretch(sim)
        lengths = _REACH - min(1.0, since / _DRAWN) * self._ways
        model.tendon_lengthspring[tendons] = lengths[:, None]

    def _stretch(self, sim: SimulatedRobot) -> FloatArray:
        """Fix the springs' far ends in the room, and how far (3,) each is to draw its point [m]."""
        model, data = sim.physics.model, sim.data
        body = model.body(sole_name(self.foot)).id
        turn = data.xmat[body].reshape(3, 3)
        yaw = math.atan2(turn[1, 0], turn[0, 0])
        for name, way in zip(self.springs, _WAYS @ _turned(yaw).T, strict=True):
            near, far = model.site(name).id, model.site(f"{name}/room").id
            model.site_pos[far] = data.site_xpos[near] + _REACH * np.array([*way, 0.0])
        dx, dy, dtheta = self.slip.shift
        moved = np.array([dx, dy]) + _POINTS @ _turned(dtheta).T - _POINTS
        ways: FloatArray = (moved * _WAYS).sum(axis=1)
        return ways


def _turned(angle: float) -> FloatArray:
    """(2, 2) rotation about z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


EFFECTS: dict[str, Callable[[Fields], Effect]] = {"slip": Slip.read}
"""Effects of this family by identifier."""
