"""A fault of the planner itself leaves no robot moving unwatched."""

from __future__ import annotations

from pathlib import Path

import pytest
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import nao
from ros.following_robot import FollowingRobot
from ros.nodes.test_planner_watch import PATIENT
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_from_ros


def test_the_robot_is_stopped_and_the_goal_answered(world: World) -> None:
    robot = FollowingRobot(world, DoubleSupport(0.02, -0.11, 0.1))
    commands = world.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    faulty = Path(__file__).with_name("faulty_planner.py")
    world.start("planner", PATIENT, script=faulty)
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    assert world.call(SetBool, "shoe/arm", SetBool.Request(data=True)).success

    result = world.goal(Plan, "shoe/plan", Plan.Goal(motion="landmarks", send=True)).result()
    assert (result.success, result.error_code) == (False, Plan.Result.FAILED)
    assert "ZeroDivisionError: made up, of two lines; see the node's log" in result.message
    world.until_logged("planner", "Traceback")
    world.until(lambda: len(commands.last.points) == 1)
    hold = trajectory_from_ros(commands.last).full(nao(), robot.angles)
    assert hold.positions[-1] == pytest.approx(robot.angles, abs=0.05)

    again = world.goal(Plan, "shoe/plan", Plan.Goal(motion="landmarks")).result()
    assert again.success, again.message
