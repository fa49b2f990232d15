"""What acts on a simulated robot from outside, and what of the robot it may change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import mujoco

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.robot.robot import Robot
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.sampled_parts import link_names


class MovingRobot(Protocol):
    """A simulated robot, as far as disturbances need it.

    Attributes:
        robot: as its files say.
        physics: as MuJoCo runs it.
        data: MuJoCo's state.
        run: number of the session's run that was begun last, from 1; 0 before the first.
        strain: (a,) what servos aim at in this period less their commands [rad].
    """

    robot: Robot
    physics: RobotPhysics
    data: mujoco.MjData
    run: int
    strain: FloatArray


class Disturbance(Protocol):
    """Something that acts on a robot while it moves.

    The robot lets every one act once in each period of its servos, after it has cleared the forces
    of the period before.
    """

    def act(self, sim: MovingRobot, time: float) -> None:
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

    def act(self, sim: MovingRobot, time: float) -> None:
        """Push while it is time.

        Raises:
            NameNotFoundError: for a link that the robot does not have.
        """
        names = link_names(sim.robot)
        if self.link not in names:
            raise NameNotFoundError("link", self.link, names)
        if self.start <= time < self.end:
            sim.data.xfrc_applied[sim.physics.model.body(self.link).id, :3] += self.force
