"""The robots that the model is tested with, with and without shoes."""

from __future__ import annotations

from functools import cache

import numpy as np

from core.shoe import shoes
from core.shoe.shoes import ROOT
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot

FILES = {
    "nao": ROOT / "config/robots/nao.yaml",
    "wren": ROOT / "config/robots/wren.yaml",
    "odd_biped": ROOT / "test/data/robots/odd_biped.yaml",
}
SHOES = {"nao": "nao_shoe", "wren": "wren_shoe", "odd_biped": "odd_shoe"}
NAMES = tuple(FILES)


@cache
def load(name: str, *, shod: bool = True) -> Robot:
    """One of the robots."""
    return load_robot(FILES[name], shoes.shoe(SHOES[name]) if shod else None)


@cache
def kinematics(name: str, *, shod: bool = True) -> Kinematics:
    """Compiled once."""
    return Kinematics(load(name, shod=shod))


def random_angles(robot: Robot, count: int, seed: int = 0) -> FloatArray:
    """(count, m) joint angles within the limits; shared motors turn together."""
    draw = np.random.default_rng(seed).uniform(
        robot.lower, robot.upper, (count, len(robot.joint_names))
    )
    for shared in robot.shared:
        draw[:, shared.joint] = shared.ratio * draw[:, shared.leader]
    return draw
