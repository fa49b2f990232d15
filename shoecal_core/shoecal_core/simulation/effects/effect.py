"""What an effect of the real world can change."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Sequence

import mujoco

from shoecal_core.robot.robot import Robot
from shoecal_core.simulation.disturbances import Disturbance
from shoecal_core.simulation.sampled_parts import SampledBody, SampledShoes
from shoecal_core.simulation.stage import AnyStage


class Effect:
    """One effect of the real world; without more it changes nothing.

    Identifiers, locations and sizes are those that a diagnosis reports; what they do here is the
    physics, or a law of another form than a diagnosis would fit.

    An effect that is none of the library's is a class of one's own with any of these methods, put
    among `Reality.effects` by `dataclasses.replace`: all that a reality file can say, bodies and
    springs of one's own in the physics, forces that act while the robot moves.
    """

    def on_body(self, body: SampledBody) -> SampledBody:
        """The robot with this effect."""
        return body

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes, and the floor below them, with this effect."""
        return shoes

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:
        """Change the physics before it is compiled: links and joints bear the URDF's names.

        `shoe_physics.sole_name` and the channels' names name what is added for the shoes: bodies
        of the bottom plates, and a tendon for each cell.
        """

    def disturbances(self) -> Sequence[Disturbance]:
        """What acts on one robot while it moves: new ones for each robot."""
        return ()


class SensorEffect(Effect):
    """An effect that is one stage on the way from a channel to its converter."""

    @abstractmethod
    def stage(self, shoes: SampledShoes) -> AnyStage:
        """The stage in a pair of shoes.

        Raises:
            FileError: when these shoes lack what it names, or it makes no sense in them.
        """

    def on_shoes(self, shoes: SampledShoes) -> SampledShoes:
        """The shoes with this stage added."""
        return dataclasses.replace(shoes, stages=(*shoes.stages, self.stage(shoes)))
