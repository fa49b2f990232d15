"""What befalls a simulated robot from outside.

The robot lets every disturbance act once in each period of its servos, after it has cleared the
forces of the period before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import NameNotFoundError
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import link_names

FloatArray = NDArray[np.float64]


class Disturbance(Protocol):
    """Something that acts on a robot while it moves."""

    def act(self, sim: SimulatedRobot, time: float) -> None:
        """Add the forces that are due, or to what strains the servos.

        Args:
            sim: that they act on: `sim.data.xfrc_applied`, `qfrc_applied` or `sim.strain`.
            time: since the run began [s]; minus infinity before it begins.
        """


@dataclass(frozen=True)
class Push:
    """A steady force on a link's centre of mass; upwards it holds the robot, downwards it loads it.

    Attributes:
        link: name in the URDF.
        force: (3,) in the floor's frame [N].
        start, end: since the run began [s].
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
