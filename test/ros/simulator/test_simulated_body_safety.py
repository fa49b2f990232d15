from __future__ import annotations

import numpy as np
import pytest

from ros.bodies import nao
from shoecal_core.errors import NameNotFoundError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.hold import HOLD_WAY, is_hold


@pytest.mark.parametrize(
    ("way", "points", "hold"), [(0.1, 1, True), (2.0 * HOLD_WAY, 1, False), (0.1, 2, False)]
)
def test_a_hold_is_one_point_near_the_joints(way: float, points: int, hold: bool) -> None:
    robot = nao()
    name = robot.joint_names[3]
    times = np.arange(1.0, points + 1.0)
    command = JointTrajectory((name,), times, np.full((points, 1), robot.posture[3] + way))
    assert is_hold(command, robot, robot.posture) == hold


def test_a_hold_of_an_unknown_joint() -> None:
    command = JointTrajectory(("Tail",), np.ones(1), np.zeros((1, 1)))
    with pytest.raises(NameNotFoundError, match="Tail"):
        is_hold(command, nao(), nao().posture)
