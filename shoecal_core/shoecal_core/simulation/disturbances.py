"""What befalls a simulated robot from outside: pushes, and a foot that slips.

`disturb` is called again and again while the robot moves; each disturbance then does to the
physics what is due.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import NameNotFoundError
from shoecal_core.simulation.drawn import link_names
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.shoe_physics import sole_name

FloatArray = NDArray[np.float64]

_ICE = 0.02
"""Friction below a foot while it slips."""
_GRIP, _STRONGEST = 6000.0, 25.0
"""N/m, N; how a foot is pulled while it slips."""
_PULLED = 0.7
"""Part of a slip's time after which the foot has been pulled all the way."""


class Disturbance(Protocol):
    """Something that acts on a robot while it moves."""

    def act(self, sim: SimulatedRobot, time: float) -> None:
        """Add the forces that are due at a time since the recording began [s]."""


def disturb(sim: SimulatedRobot, time: float, disturbances: Sequence[Disturbance]) -> None:
    """Let every disturbance act; forces of the moment before are gone."""
    sim.data.xfrc_applied[:] = 0.0
    for disturbance in disturbances:
        disturbance.act(sim, time)


@dataclass(frozen=True)
class Push:
    """A steady force on a link's centre of mass; upwards it holds the robot, downwards it loads it.

    Attributes:
        link: name in the URDF.
        force: (3,) in the floor's frame [N].
        start, end: since the recording began [s].
    """

    link: str
    force: FloatArray
    start: float
    end: float

    def act(self, sim: SimulatedRobot, time: float) -> None:
        """Push while it is time.

        Raises:
            NameNotFoundError: for a link that the robot does not have.
        """
        names = link_names(sim.robot)
        if self.link not in names:
            raise NameNotFoundError("link", self.link, names)
        if self.start <= time < self.end:
            sim.data.xfrc_applied[sim.physics.model.body(self.link).id, :3] += self.force


@dataclass
class Slip:
    """A foot loses its grip for a moment and is pulled aside; where it comes to rest, it stays.

    The legs spring back when it is let go, so it ends less far away than it was pulled.

    Attributes:
        foot: 0 left, 1 right.
        pull: (2,) how far it is pulled, in the floor's frame [m].
        start: since the recording began [s].
        duration: [s].
    """

    foot: int
    pull: FloatArray
    start: float
    duration: float = 0.4
    _from: FloatArray | None = field(default=None, init=False)

    def act(self, sim: SimulatedRobot, time: float) -> None:
        """Loosen and pull, or hold fast again."""
        model, data = sim.physics.model, sim.data
        body = model.body(sole_name(self.foot)).id
        slips = self.start <= time < self.start + self.duration
        tips = np.flatnonzero(model.geom_bodyid == body)
        # With priority the tips' own friction counts, not the floor's greater one.
        model.geom_priority[tips] = int(slips)
        model.geom_friction[tips, 0] = _ICE if slips else sim.drawn.rules.floor.friction
        if slips:
            place = data.xpos[body, :2].copy()
            self._from = place if self._from is None else self._from
            reached = min(1.0, (time - self.start) / (_PULLED * self.duration))
            missing = self._from + reached * self.pull - place
            force = _GRIP * missing
            size = float(np.linalg.norm(force))
            data.xfrc_applied[body, :2] += force * min(1.0, _STRONGEST / max(size, 1e-9))
