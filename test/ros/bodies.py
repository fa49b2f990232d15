"""The robots and shoes that the nodes are tested with, and readings that belong to forces."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters

ROOT = Path(__file__).parents[2]
NAO = ROOT / "config/robots/nao.yaml"
NAO_SHOE = ROOT / "config/shoes/nao_shoe.yaml"
ODD = ROOT / "test/data/robots/odd_biped.yaml"
ODD_SHOE = ROOT / "test/data/shoes/odd_shoe.yaml"


@cache
def nao_shoe() -> Shoe:
    return load_shoe(NAO_SHOE)


@cache
def nao() -> Robot:
    return load_robot(NAO, nao_shoe())


def parameters(shoe: Shoe) -> ChannelParameters:
    """Some gains with the shoe's polarities, and some offsets."""
    rng = np.random.default_rng(3)
    sign = np.where(shoe.polarity == 0, 1, shoe.polarity)
    count = len(shoe.names)
    return ChannelParameters(sign * rng.uniform(8.0, 15.0, count), rng.uniform(-3.0, 3.0, count))


def calibration(
    robot: Robot, shoe: Shoe, identity: str = "made-1", **changes: object
) -> Calibration:
    """A calibration with those parameters."""
    values: dict[str, object] = {
        "id": identity,
        "source": "self",
        "made_ns": 10**18,
        "robot": robot.name,
        "shoe": shoe.name,
        "robot_hash": robot.digest,
        "shoe_hash": shoe.digest,
        "channels": shoe.names,
        "parameters": parameters(shoe),
        "covariance": None,
        "corrections": (),
        "weight": robot.weight,
        "time_offset": 0.0,
        "temperature": float("nan"),
        "verdict": "PASS",
        "reasons": ("every check passed",),
        **changes,
    }
    return Calibration(**values)  # type: ignore[arg-type]


def readings(shoe: Shoe, law: ChannelParameters, outputs: FloatArray) -> FloatArray:
    """Readings (..., n) of outputs (..., n) [N]."""
    found: FloatArray = (outputs - law.offset) / law.gain
    return found
