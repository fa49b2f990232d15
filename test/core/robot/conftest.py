"""Both robots, barefoot and in shoes."""

from __future__ import annotations

import pytest

from core.robot import robots
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot


@pytest.fixture(params=[(n, s) for n in robots.NAMES for s in (True, False)], ids=str)
def kinematics(request: pytest.FixtureRequest) -> Kinematics:
    name, shod = request.param
    return robots.kinematics(name, shod=shod)


@pytest.fixture
def robot(kinematics: Kinematics) -> Robot:
    """The robot of `kinematics`."""
    return kinematics.robot


@pytest.fixture
def nao() -> Robot:
    return robots.load("nao")
