from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Plan, ReachSupport
from shoecal_msgs.msg import DoubleSupport, ShoeState
from std_msgs.msg import Bool
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import nao
from ros.rest import until_still
from ros.world import Goal, Received, World
from shoecal_core.planning.posture import stance
from shoecal_core.robot.double_support import DoubleSupport as Support
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import (
    JointSample,
    joints_to_ros,
    trajectory_from_ros,
)

SUPPORT = DoubleSupport(dx=0.02, dy=-0.11, dtheta=0.1)
QUICK = {
    "tilt_required": False,
    "load_required": False,
    "stale_s": 10.0,
    "follow_late": 4.0,
    "planning.horizon": 5,
    "planning.landmark_radius": 0.012,
    "planning.com_speed": 0.03,
}
"""Shorter planning and motions, and patience on a busy machine."""


def plan(world: World, **goal: object) -> Goal:
    return world.goal(Plan, "shoe/plan", Plan.Goal(**{"motion": "landmarks", **goal}))


def arm(world: World, armed: bool = True) -> None:
    assert world.call(SetBool, "shoe/arm", SetBool.Request(data=armed)).success


def is_moving(goal: Goal) -> bool:
    assert not goal.done, goal.result().message
    return any(one.phase == "moving" and one.progress > 0.2 for one in goal.feedback)


def has_begun(goal: Goal) -> bool:
    return bool(goal.feedback) or goal.done


def is_hold(commands: Received, after: int = 0) -> bool:
    return len(commands) > after and len(commands.last.points) == 1


def more(heard: Received, count: int) -> bool:
    return len(heard) > count


class StillRobot:
    """Tells joint angles and follows nothing."""

    def __init__(self, world: World) -> None:
        self._angles = nao().from_legs(stance(nao(), Support(0.02, -0.11, 0.1)))
        self._publisher = world.node.create_publisher(JointState, "joint_states", qos.RAW)
        self._stamp_ns = 10**9
        world.node.create_timer(0.02, self._tell)

    def _tell(self) -> None:
        self._stamp_ns += 20_000_000
        sample = JointSample(self._stamp_ns, nao().joint_names, self._angles)
        self._publisher.publish(joints_to_ros(sample))


@pytest.fixture
def still(world: World) -> World:
    """A planner beside a robot that does not move."""
    StillRobot(world)
    world.start("planner", QUICK)
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    return world


@pytest.fixture
def simulated(world: World) -> World:
    """A planner beside the simulated robot, which stands in a double support."""
    world.start("simulator", {"port": world.folder / "port", "speed": 4.0})
    world.start("planner", {**QUICK, "use_sim_time": True})
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    arm(world)
    reached = world.goal(ReachSupport, "robot/reach_support", ReachSupport.Goal(support=SUPPORT))
    assert reached.result().success
    return world


def test_lines_of_a_goal_bear_the_id_of_its_job(still: World) -> None:
    anything = "one\ntwo/../" + 5000 * "x"
    refused = plan(still, motion="dance\nnow", run_id=anything).result()
    assert refused.error_code == Plan.Result.BAD_GOAL
    still.until_logged("planner", "xxx...] motion 'dance now' ended: no motion named")
    said = still.output("planner").splitlines()
    lines = [line for line in said if "[one two/../xxx" in line]
    assert [line.rpartition("] ")[2].partition(":")[0] for line in lines] == [
        "motion 'dance now' begins", "motion 'dance now' ended",
    ]  # fmt: skip
    assert max(map(len, lines)) < 500
    assert still.call(SetBool, "shoe/arm", SetBool.Request(data=True)).success
    still.until_logged("planner", "]: arming: armed")


def test_a_plan_without_sending_moves_nothing(still: World) -> None:
    commands = still.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    goal = plan(still, run_id="20261122T034512123")
    result = goal.result()
    still.until_logged("planner", "[20261122T034512123] motion 'landmarks' done")
    # Whatever else it says meanwhile, too.
    still.until_logged("planner", "[20261122T034512123] planning: at work")
    assert (result.success, result.error_code) == (True, Plan.Result.OK), result.message
    trajectory = trajectory_from_ros(result.trajectory)
    robot = nao()
    assert set(trajectory.names) == {*robot.leg_names, "RHipYawPitch"}
    start = robot.from_legs(stance(robot, Support(0.02, -0.11, 0.1)))
    columns = [robot.joint(name) for name in trajectory.names]
    np.testing.assert_allclose(trajectory.positions[0], start[columns], atol=1e-6)
    assert len(result.landmark_distance) == 5
    assert {feedback.phase for feedback in goal.feedback} == {"planning"}
    assert not len(commands)


def test_goals_that_are_refused_at_once(still: World) -> None:
    """Nothing is sent before it is armed, and no goal that makes no sense is planned."""
    codes = Plan.Result
    goals: list[tuple[dict[str, object], int, str]] = [
        ({"send": True}, codes.NOT_ARMED, "shoe/arm"),
        ({"motion": "dance"}, codes.BAD_GOAL, "landmarks"),
        ({"stream": True}, codes.BAD_GOAL, "ask to send it"),
    ]
    for goal, code, problem in goals:
        result = plan(still, **goal).result()
        assert result.error_code == code
        assert problem in result.message


def test_a_robot_that_does_not_follow_is_told_to_hold(still: World) -> None:
    commands = still.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    still.until_reported("planner", "commands", "goes to '/tester'")
    arm(still)
    result = plan(still, send=True).result()
    assert result.error_code == Plan.Result.NOT_FOLLOWED
    assert "off its trajectory" in result.message
    still.until(partial(is_hold, commands))
    (point,) = commands.last.points
    start = nao().from_legs(stance(nao(), Support(0.02, -0.11, 0.1)))
    columns = [nao().joint(name) for name in commands.last.joint_names]
    np.testing.assert_allclose(point.positions, start[columns], atol=1e-6)


def test_nothing_is_sent_while_nobody_listens(still: World) -> None:
    arm(still)
    still.until_reported("planner", "commands", "no node subscribes to /joint_trajectory")
    recorder = still.companion("calibrator")
    recorder.create_subscription(JointTrajectoryMsg, "joint_trajectory", print, qos.COMMAND)
    still.until_discovered_by("planner", recorder)
    # By its name, too.
    still.forget("planner")
    still.until_reported("planner", "commands", "no node subscribes to /joint_trajectory")
    result = plan(still, send=True).result()
    assert result.error_code == Plan.Result.NOT_FOLLOWED
    assert "not begun: no node subscribes to /joint_trajectory" in result.message
    robot = still.companion("robot")
    robot.create_subscription(JointTrajectoryMsg, "joint_trajectory", print, qos.COMMAND)
    still.until_reported("planner", "commands", "goes to '/robot'")
    goal = plan(still, send=True)
    still.until(lambda: goal.done or any(one.phase == "moving" for one in goal.feedback))
    still.dismiss(robot)
    result = goal.result()
    assert result.error_code == Plan.Result.NOT_FOLLOWED
    assert "stopped: no node subscribes to /joint_trajectory" in result.message


def test_one_motion_at_a_time_and_cancelling_while_planning(world: World) -> None:
    # The slow solver, far ahead and in tiny steps: a motion takes it minutes, so it is surely still
    # being planned when something comes, on a busy machine too.
    StillRobot(world)
    slow = {
        "stale_s": 10.0,
        "planning.solver": "ipopt",
        "planning.horizon": 40,
        "planning.joint_speed": 0.005,
        "planning.steps_max": 10_000,
    }
    world.start("planner", slow)
    world.until_reported("planner", "planning", "ready")
    world.until_reported("planner", "joints", "come")
    for _ in range(2):
        goal = plan(world)
        world.until(partial(has_begun, goal))
        assert plan(world).result().error_code == Plan.Result.BUSY
        goal.cancel()
        assert goal.result().error_code == Plan.Result.CANCELED


@pytest.mark.parametrize("named", ["", "other, walker"])
def test_nobody_else_commands_an_armed_robot_but_who_may(world: World, named: str) -> None:
    world.start("planner", {**QUICK, "other_commanders": named})
    armed = world.receive(Bool, "shoe/armed", qos.ARMED)
    arm(world)
    world.until(lambda: any(one.data for one in armed.messages))
    rival = world.companion("walker")
    rival.create_publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    world.until_discovered_by("planner", rival)
    if named:
        heard = len(armed)
        world.until(partial(more, armed, heard + 25))
        assert armed.last.data
        return
    reported = "'/walker' publishes /joint_trajectory, too; stop one of them"
    status = world.until_reported("planner", "commands", reported)
    assert "other_commanders" in status.message
    world.until(lambda: not armed.last.data)
    answer = world.call(SetBool, "shoe/arm", SetBool.Request(data=True))
    assert not answer.success
    assert f"not armed: {reported}" in answer.message
    world.dismiss(rival)
    world.until_reported("planner", "commands", "no node subscribes")
    arm(world)


def test_while_a_job_moves_the_robot_only_its_own_goals_are_taken(still: World) -> None:
    states = still.publisher(ShoeState, "shoe/state", qos.LATCHED)

    def asked(run_id: str = "") -> Plan.Result:
        return plan(still, motion="dance", run_id=run_id).result()

    states.publish(ShoeState(state=ShoeState.CALIBRATING, run_id="20261122T034512123"))
    still.until_discovered_by("planner")
    still.until(lambda: asked().error_code == Plan.Result.BUSY)
    for refused in (asked(), asked("20261122T000000000")):
        assert refused.error_code == Plan.Result.BUSY
        assert "job 20261122T034512123 moves the robot; wait for it" in refused.message
    assert asked("20261122T034512123").error_code == Plan.Result.BAD_GOAL
    # It ends while one waits.
    waiting = plan(still, motion="dance")
    states.publish(ShoeState(state=ShoeState.CALIBRATED))
    assert waiting.result().error_code == Plan.Result.BAD_GOAL


def test_without_joint_angles(world: World) -> None:
    world.start("planner", QUICK)
    result = plan(world).result()
    assert result.error_code == Plan.Result.NO_JOINT_STATES
    assert "joint_states" in result.message


def test_arming_ends_by_itself(world: World) -> None:
    world.start("planner", {**QUICK, "arm_timeout_s": 1.0})
    armed = world.receive(Bool, "shoe/armed", qos.ARMED)
    world.until(lambda: len(armed))
    assert not armed.last.data
    arm(world)
    world.until(lambda: any(one.data for one in armed.messages))
    world.until(lambda: not armed.last.data)


def test_a_motion_is_sent_and_followed_to_its_end(simulated: World) -> None:
    # A fast robot tells more than this client takes in: only what it does now counts.
    joints = simulated.receive(JointState, "joint_states", qos.NEWEST)
    goal = plan(simulated, send=True)
    result = goal.result()
    assert (result.success, result.error_code) == (True, Plan.Result.OK), result.message
    assert {feedback.phase for feedback in goal.feedback} == {"planning", "moving"}
    seen = len(joints)
    simulated.until(lambda: len(joints) > seen)
    trajectory = trajectory_from_ros(result.trajectory)
    names = list(joints.last.name)
    end = np.array([joints.last.position[names.index(name)] for name in trajectory.names])
    assert np.abs(end - trajectory.positions[-1]).max() < 0.05


def test_cancelling_and_disarming_stop_the_robot(simulated: World) -> None:
    commands = simulated.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    for stop, code in (("cancel", Plan.Result.CANCELED), ("disarm", Plan.Result.NOT_ARMED)):
        sent = len(commands)
        goal = plan(simulated, send=True)
        simulated.until(partial(is_moving, goal))
        if stop == "cancel":
            goal.cancel()
        else:
            arm(simulated, False)
        result = goal.result()
        assert result.error_code == code, result.message
        simulated.until(partial(is_hold, commands, sent))
        until_still(simulated)


def test_a_robot_whose_planner_is_killed_comes_to_rest_and_nobody_has_to_see_to_it(
    simulated: World,
) -> None:
    commands = simulated.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    goal = plan(simulated, send=True)
    simulated.until(partial(is_moving, goal))
    simulated.kill("planner")
    until_still(simulated)
    trajectory = trajectory_from_ros(commands.last)
    assert len(trajectory.times) > 1, "no hold: the piece that was sent ends at rest"
    assert trajectory.velocities is not None
    assert not trajectory.velocities[-1].any()


def test_a_streamed_motion_is_planned_from_where_the_robot_is(simulated: World) -> None:
    commands = simulated.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
    result = plan(simulated, send=True, stream=True).result()
    assert (result.success, result.error_code) == (True, Plan.Result.OK), result.message
    assert len(commands) > 2
    assert len(result.landmark_distance) == 5
    trajectory_from_ros(result.trajectory)


def test_a_parameter_that_no_node_has_is_told_and_nothing_starts(world: World) -> None:
    world.start("planner", {"horizon": 5})
    assert world.ended("planner") == 1
    reported = world.output("planner").strip().splitlines()[-1]
    assert "planner: horizon: node planner has no such parameter" in reported
    assert "planning.horizon" in reported
