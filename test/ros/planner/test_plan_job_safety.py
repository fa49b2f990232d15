from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Plan

from ros.bodies import nao
from ros.clock import Clock
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.order import Mover
from shoecal_ros.planner.plan_job import PlanJob
from shoecal_ros.planner.settings import MovingSettings


@pytest.mark.parametrize("following", [True, False])
def test_a_job_that_is_ended_holds_a_moving_robot_where_it_is(following: bool) -> None:
    robot = nao()
    sent: list[JointTrajectory] = []
    latest = JointBatch(np.array([1]), robot.posture[None])
    mover = SimpleNamespace(
        robot=robot,
        moving=MovingSettings(),
        arming=Arming(10.0, Clock()),
        joints=SimpleNamespace(latest=latest),
        command=sent.append,
    )
    goal = SimpleNamespace(request=Plan.Goal())
    job = PlanJob(cast(Mover, mover), cast(ServerGoalHandle, goal), Plan.Result())
    job.execution.following = following
    job.execution.halt()
    job.execution.halt()
    assert len(sent) == following, "once, and only where there is something to stop"
    for hold in sent:
        columns = [robot.joint(name) for name in hold.names]
        np.testing.assert_allclose(hold.positions, robot.posture[None, columns])
