"""Double supports reached by own steps, for robots without a walk engine."""

from __future__ import annotations

import numpy as np
import pytest
from rclpy.action import ActionServer
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan, ReachSupport
from shoecal_msgs.msg import DoubleSupport
from std_srvs.srv import SetBool

from ros.bodies import nao
from ros.world import Goal, Received, World
from shoecal_core.robot.double_support import DoubleSupport as Support
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.common.health import Level

PATIENT = {
    "stale_s": 10.0,
    "follow_late": 4.0,
    "tilt_required": False,
    "load_required": False,
}
"""For a busy machine."""
NEAR = DoubleSupport(dx=0.02, dy=-0.115, dtheta=0.1)
FAR = DoubleSupport(dx=-0.02, dy=-0.12, dtheta=-0.1)
ELSEWHERE = DoubleSupport(dx=0.03, dy=-0.12, dtheta=0.0)


def reach(world: World, support: DoubleSupport) -> Goal:
    return world.goal(ReachSupport, "robot/reach_support", ReachSupport.Goal(support=support))


def stands(joints: Received) -> Support:
    angles = nao().from_measured(joints.last.name, np.array(joints.last.position))
    return Kinematics(nao()).states(angles[None]).support()


def lifted(joints: Received) -> float:
    """Height of the right sole over the left one, as encoders tell it [m]."""
    angles = nao().from_measured(joints.last.name, np.array(joints.last.position))
    return float(Kinematics(nao()).states(angles[None]).translation[0, 2])


def until_still(world: World, joints: Received) -> None:
    """Wait until the joints are where they were a second of the robot's time ago."""
    before = joints.last

    def still() -> bool:
        nonlocal before
        now = joints.last
        if time_from_ros(now.header.stamp) - time_from_ros(before.header.stamp) < 10**9:
            return False
        moved = np.abs(np.array(now.position) - np.array(before.position)).max()
        before = now
        return bool(moved < 2e-3)

    world.until(still)


@pytest.fixture
def walking(world: World) -> World:
    """The simulated robot, which has to step by itself."""
    body = {"port": world.folder / "port", "speed": 3.0, "offer_reach_support": False}
    world.start("simulator", body)
    world.start("planner", {**PATIENT, "use_sim_time": True, "steps": True})
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    return world


def test_a_support_is_reached_by_own_steps(walking: World) -> None:
    # A fast robot tells more than this client takes in: only what it does now counts.
    joints = walking.receive(JointState, "joint_states", qos.NEWEST)
    asked = ReachSupport.Goal(support=NEAR, run_id="20261122T034512123")
    refused = walking.goal(ReachSupport, "robot/reach_support", asked).result()
    assert refused.error_code == ReachSupport.Result.NOT_ARMED
    walking.until_logged("planner", "[20261122T034512123] stepping to a double support ended: not")
    assert walking.call(SetBool, "shoe/arm", SetBool.Request(data=True)).success
    for nowhere in (DoubleSupport(dx=0.5, dy=-0.1), DoubleSupport(dx=float("nan"))):
        far = reach(walking, nowhere).result()
        assert far.error_code == ReachSupport.Result.UNREACHABLE, far.message

    goal = reach(walking, NEAR)
    walking.until(lambda: goal.done or any(one.progress > 0.1 for one in goal.feedback))
    busy = walking.goal(Plan, "shoe/plan", Plan.Goal(motion="landmarks")).result()
    assert busy.error_code == Plan.Result.BUSY
    result = goal.result()
    assert (result.success, result.error_code) == (True, ReachSupport.Result.OK), result.message
    reported = [one.progress for one in goal.feedback]
    assert reported == sorted(reported)
    there = stands(joints)
    assert there.dx == pytest.approx(NEAR.dx, abs=0.005)
    assert there.dy == pytest.approx(NEAR.dy, abs=0.005)
    assert there.dtheta == pytest.approx(NEAR.dtheta, abs=0.03)
    walking.until_reported("simulator", "robot", "stands")

    unloaded = walking.goal(Plan, "shoe/plan", Plan.Goal(motion="unload_left", send=True))
    assert unloaded.result().success, unloaded.result().message

    # Stopped in mid-swing it puts its foot down first, when asked to or to step on.
    for support, ask in ((FAR, _put_down), (ELSEWHERE, _step_on)):
        _stop_in_mid_swing(walking, joints, support)
        until_still(walking, joints)
        ask(walking)
        assert abs(lifted(joints)) < 0.005


def test_two_nodes_that_offer_to_step_are_told_of(world: World) -> None:
    world.start("planner", {**PATIENT, "steps": True})
    world.until_reported("planner", "steps", "this node offers robot/reach_support")
    other = ActionServer(world.node, ReachSupport, "robot/reach_support", lambda _: None)
    reported = world.until_reported(
        "planner", "steps", "another node offers robot/reach_support too"
    )
    assert reported.level == bytes([Level.WARN])
    other.destroy()
    world.until_reported("planner", "steps", "this node offers robot/reach_support")


def _put_down(world: World) -> None:
    result = world.goal(Plan, "shoe/plan", Plan.Goal(motion="put_down", send=True)).result()
    assert result.success, result.message


def _step_on(world: World) -> None:
    result = reach(world, ELSEWHERE).result()
    assert result.success, result.message


def _stop_in_mid_swing(world: World, joints: Received, support: DoubleSupport) -> None:
    """Cancel a step while its foot is up: again from elsewhere where the foot was down too soon."""
    while True:
        goal = reach(world, support)
        world.until(lambda: goal.done or abs(lifted(joints)) > 0.009)  # noqa: B023
        if not goal.done:
            goal.cancel()
        result = goal.result()
        if "foot: arm and plan motion 'put_down'" in result.message:
            assert result.error_code == ReachSupport.Result.CANCELED, result.message
            return
        back = reach(world, NEAR).result()
        assert back.success, back.message
