"""What a person does before a run: waits, turns the robot on its floor, hangs a weight on it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from shoecal_core.model.robot import Robot
from shoecal_core.simulation.drawn import DrawnShoes, draw, link_names
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.robot import SimulatedRobot

RADIUS = 0.02
"""Of the ball that the known weight is [m]."""


@dataclass(frozen=True)
class ByHand:
    """What is done, and the motion that the robot then follows.

    Attributes:
        motion: on the planner's menu.
        wait: before it [s].
        turned: the robot by 180 degrees on the same floor.
        mass: fastened to the torso, at the origin of its frame [kg].
    """

    motion: str
    wait: float = 0.0
    turned: bool = False
    mass: float = 0.0


BY_HAND: Mapping[str, ByHand] = {
    "turn_180": ByHand("landmarks", turned=True),
    "warm_up": ByHand("hold", wait=600.0),
    "known_weight": ByHand("landmarks", mass=0.5),
}
"""By the name that the diagnosis proposes."""


def after(done: ByHand, before: SimulatedRobot, noise: np.random.Generator) -> SimulatedRobot:
    """The same robot afterwards: its session's time and its runs go on.

    Args:
        done: by hand. before: as it was.
        noise: draws the noise of its readings from now on.
    """
    rules, drawn = before.drawn.rules, before.drawn
    changes: list[Effect] = []
    if done.turned:
        changes.append(_Turned())
    if done.mass > 0.0:
        changes.append(_Loaded(done.mass))
    rules = dataclasses.replace(rules, effects=(*rules.effects, *changes))
    robot = SimulatedRobot(
        before.robot,
        before.shoe,
        draw(rules, before.robot, before.shoe, drawn.seed),
        noise,
        made_at=before.session_time + done.wait,
    )
    robot.run = before.run
    return robot


class _Turned(Effect):
    """Whoever turns on a slope by 180 degrees sees it lean the other way."""

    def on_shoes(self, shoes: DrawnShoes) -> DrawnShoes:
        return dataclasses.replace(shoes, tilt=-shoes.tilt)


@dataclass(frozen=True)
class _Loaded(Effect):
    """A ball at the origin of the root link's frame."""

    mass: float

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:
        ball = spec.body(link_names(robot)[0]).add_body(name="known weight")
        ball.mass, ball.ipos = self.mass, np.zeros(3)
        ball.inertia = np.full(3, 0.4 * self.mass * RADIUS**2)
        ball.explicitinertial = True
