"""Robots, shoes and realities that the simulation is tested with."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.reality import NamedNumbers, PlantVariation
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw

ROOT = Path(__file__).parents[3]
REALITIES = ROOT / "config" / "realities"
DEFAULT = load_reality(REALITIES / "default.yaml")
PERFECT = load_reality(REALITIES / "default.yaml", REALITIES / "perfect.yaml")

_FILES = {
    "nao": ("config/robots/nao.yaml", "config/shoes/nao_shoe.yaml"),
    "odd_biped": ("test/data/robots/odd_biped.yaml", "test/data/shoes/odd_shoe.yaml"),
}
NAMES = tuple(_FILES)


@dataclass(frozen=True)
class World:
    """A robot in its shoes."""

    robot: Robot
    shoe: Shoe
    kinematics: Kinematics

    def simulate(self, rules: PlantVariation, seed: int = 1) -> SimulatedRobot:
        """The robot that a seed draws, in its own posture, just above the floor."""
        drawn = draw(rules, self.robot, self.shoe, seed)
        return SimulatedRobot(self.robot, self.shoe, drawn, np.random.default_rng(seed))

    def standing(self, rules: PlantVariation, seed: int = 1) -> SimulatedRobot:
        """The same, at rest on the floor."""
        sim = self.simulate(rules, seed)
        sim.place(self.robot.posture)
        return sim


@cache
def load_world(name: str) -> World:
    robot_file, shoe_file = _FILES[name]
    shoe = load_shoe(ROOT / shoe_file)
    robot = load_robot(ROOT / robot_file, shoe)
    return World(robot, shoe, Kinematics(robot))


def changed(
    rules: PlantVariation, *effects: Effect, **values: float | Mapping[str, float]
) -> PlantVariation:
    """Rules with some keys changed; `section__key` names a key, a mapping makes a table."""
    for name, value in values.items():
        section, key = name.split("__")
        entry: float | NamedNumbers = (
            value
            if isinstance(value, int | float)
            else NamedNumbers({one: (row,) for one, row in value.items()}, Path("a.yaml"), key)
        )
        part = dataclasses.replace(getattr(rules, section), **{key: entry})
        rules = dataclasses.replace(rules, **{section: part})
    return dataclasses.replace(rules, effects=(*rules.effects, *effects))
