"""Legs whose angles are under each other's names, by feet that stand still only without that."""

from __future__ import annotations

import numpy as np
import pytest

from core.recording.two_feet import ASTRIDE, leg_pairs, standing
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.recording.imports.standing import Feet, find_feet, find_feet_exchanged
from shoecal_core.recording.joint_series import JointSeries, Series
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_laws import Law
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.workspace import config_dir


@pytest.fixture(scope="module")
def kinematics() -> Kinematics:
    return Kinematics(load_robot(config_dir() / "robots/wren.yaml"))


@pytest.fixture
def cells() -> Shoe:
    return shoes.shoe(shoes.NAMES[0])


def series(kinematics: Kinematics, angles: FloatArray, *, exchanged: bool) -> Series:
    """By joint; each leg's under the other one's names if exchanged."""
    other = {name: name for name in kinematics.robot.joint_names}
    if exchanged:
        for left, right in leg_pairs(kinematics):
            other |= {left: right, right: left}
    time = np.linspace(0.0, 6.0, len(angles))
    return {
        other[name]: JointSeries(time, angle)
        for name, angle in zip(kinematics.robot.joint_names, angles.T, strict=True)
    }


def near(feet: Feet | None, support: DoubleSupport) -> bool:
    return feet is not None and bool(
        abs(feet.support.dx - support.dx) < 2e-3
        and abs(feet.support.dy - support.dy) < 2e-3
        and abs(feet.support.dtheta - support.dtheta) < 1e-2
    )


def test_legs_under_each_others_names(kinematics: Kinematics, cells: Shoe) -> None:
    """Only exchanged do the feet stand; of the same as it is, only as it is."""
    angles = standing(kinematics, ASTRIDE)
    sound, wrong = (series(kinematics, angles, exchanged=one) for one in (False, True))
    assert near(find_feet(kinematics, cells, sound, {}), ASTRIDE)
    assert find_feet_exchanged(kinematics, cells, sound, {}) is None
    recorded = find_feet(kinematics, cells, wrong, {})
    assert recorded.loop is not None
    assert recorded.loop.law is Law.LEGS
    assert recorded.explained
    assert near(find_feet_exchanged(kinematics, cells, wrong, {}), ASTRIDE)


def test_legs_without_angles_are_not_exchanged(kinematics: Kinematics, cells: Shoe) -> None:
    angles = dict(series(kinematics, standing(kinematics, ASTRIDE), exchanged=False))
    del angles[next(leg_pairs(kinematics))[0]]
    assert find_feet_exchanged(kinematics, cells, angles, {}) is None
