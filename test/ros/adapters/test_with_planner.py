"""The whole chain: the planner, an adapter, and a robot behind its driver's messages."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool

from ros.adapters.conftest import Begin
from ros.bodies import nao
from ros.nodes.test_planner_node import QUICK
from ros.world import Received
from shoecal_core.arrays import FloatArray
from shoecal_ros.common import qos

FAST = {**QUICK, "planning.com_speed": 0.1, "planning.hold_time": 0.2, "planning.joint_speed": 0.4}


def legs(heard: Received) -> FloatArray:
    """Angles of the planned joints, as the robot tells them [rad]."""
    message = heard.last
    reported = dict(zip(message.name, message.position, strict=True))
    return np.array([reported[name] for name in nao().leg_names])


def test_a_motion_is_planned_sent_and_done(begin: Begin) -> None:
    """By nao_lola's messages; that it arrives is what the planner sees in /joint_states."""
    robot = begin("nao_lola", "nao_lola_adapter", armed_by_test=False)
    world = robot.world
    heard = world.receive(JointState, "joint_states", qos.LIVE)
    world.start("planner", FAST)
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    first = legs(heard)
    order = Plan.Goal(motion="landmarks", send=True)
    assert world.goal(Plan, "shoe/plan", order).result().error_code == Plan.Result.NOT_ARMED
    assert np.array_equal(legs(heard), first)
    assert world.call(SetBool, "shoe/arm", SetBool.Request(data=True)).success
    robot.until_well("armed")
    done = world.goal(Plan, "shoe/plan", order).result()
    assert done.success, done.message
    planned = done.trajectory.points[-1].positions
    reported = dict(zip(done.trajectory.joint_names, planned, strict=True))
    assert legs(heard) == pytest.approx([reported[name] for name in nao().leg_names], abs=1e-3)
