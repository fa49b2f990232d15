"""A foot that slips once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import FEET
from shoecal_core.simulation.disturbances import Disturbance, MovingRobot
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.location import read_feet, read_shift
from shoecal_core.simulation.restancing import Restancing
from shoecal_core.simulation.shoe_physics import tip_geoms

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
