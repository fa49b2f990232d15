"""The robots that planning is tested with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from shoecal_core.planning.legs import Legs
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

ROOT = Path(__file__).parents[3]

_FILES = {
    "nao": ("config/robots/nao.yaml", "config/shoes/nao_shoe.yaml"),
    "wren": ("config/robots/wren.yaml", "config/shoes/wren_shoe.yaml"),
    "odd_biped": ("test/data/robots/odd_biped.yaml", "test/data/shoes/odd_shoe.yaml"),
}
NAMES = ("nao", "odd_biped")
"""Those that most tests are run with."""


@dataclass(frozen=True)
class Body:
    """A robot in its shoes, with its legs."""

    robot: Robot
    shoe: Shoe
    legs: Legs


@cache
def load_body(name: str) -> Body:
    robot_file, shoe_file = _FILES[name]
    shoe = load_shoe(ROOT / shoe_file)
    robot = load_robot(ROOT / robot_file, shoe)
    return Body(robot, shoe, Legs(robot))
