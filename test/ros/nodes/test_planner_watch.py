"""Whatever is wrong while the robot moves stops it gently, each cause with its own code."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from shoecal_msgs.action import Plan
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import nao
from ros.following_robot import FollowingRobot
from ros.world import Goal, Received, World
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_from_ros

PATIENT = {
    "stale_s": 10.0,
    "follow_late": 2.5,
    "tilt_required": False,
    "load_required": False,
}
"""For a busy machine."""
SUPPORT = DoubleSupport(0.02, -0.11, 0.1)


def height(angles: FloatArray) -> float:
    """Of the right sole over the left one [m]."""
    return float(Kinematics(nao()).states(angles[None]).translation[0, 2])


class Scene:
    """A planner and a robot that follows it."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robot = FollowingRobot(world, SUPPORT)
        self.commands: Received = world.receive(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
        world.start("planner", PATIENT)
        world.until_reported("planner", "planning", "ready")
        self.recover()

    def recover(self) -> None:
        self.robot.recover()
        self.world.forget("planner")
        for subject, reported in (("joints", "come"), ("tilt", "comes"), ("shoes", "comes")):
            self.world.until_reported("planner", subject, reported)
        self.world.until_reported("planner", "heat", "'RKneePitch' at 40")
        assert self.world.call(SetBool, "shoe/arm", SetBool.Request(data=True)).success

    def plan(self, motion: str = "landmarks") -> Goal:
        return self.world.goal(Plan, "shoe/plan", Plan.Goal(motion=motion, send=True))

    def until(self, goal: Goal, condition: Callable[[], object]) -> None:
        """Wait for something in the course of a motion."""
        self.world.until(lambda: goal.done or condition())
        assert not goal.done, goal.result().message

    def moving(self) -> Goal:
        """A motion on its way."""
        goal = self.plan()
        self.until(
            goal, lambda: any(one.phase == "moving" and one.progress > 0.1 for one in goal.feedback)
        )
        return goal

    def until_lifted(self, goal: Goal, height_m: float) -> None:
        """Wait until one foot is up; then time goes slowly, so that what comes next is in time."""
        self.until(goal, lambda: abs(self.robot.lifted) > height_m)
        self.robot.pace = 1

    def held(self) -> FloatArray:
        """(m,) joint angles of the hold that was sent."""
        self.world.until(lambda: len(self.commands.last.points) == 1)
        hold = trajectory_from_ros(self.commands.last).full(nao(), self.robot.angles)
        angles: FloatArray = hold.positions[-1]
        return angles


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    with World(tmp_path_factory.mktemp("planner")) as world:
        yield Scene(world)


@pytest.fixture
def scene(running: Scene) -> Scene:
    running.recover()
    return running


def lean(robot: FollowingRobot) -> None:
    robot.leaning = 0.2


def lose_load(robot: FollowingRobot) -> None:
    robot.loaded = [False, False]


def fall_silent(robot: FollowingRobot) -> None:
    # So slowly that the motion is still under way when that is noticed.
    robot.pace = 1
    robot.publishes_voltages = False


def heat(robot: FollowingRobot) -> None:
    robot.degc = 71.0


def slip(robot: FollowingRobot) -> None:
    robot.offset = 0.2


@pytest.mark.parametrize(
    ("cause", "code", "reported"),
    [
        (lean, Plan.Result.TILTED, "rad otherwise than its joints make it"),
        (lose_load, Plan.Result.LOAD_LOST, "foot carries nothing"),
        (fall_silent, Plan.Result.SENSORS_STALE, "shoe/voltages"),
        (heat, Plan.Result.HOT_JOINTS, "'RKneePitch' is at 71 degC"),
        (slip, Plan.Result.NOT_FOLLOWED, "joint 'LKneePitch' is"),
    ],
)
def test_each_cause_stops_the_robot_where_it_is(
    scene: Scene, cause: Callable[[FollowingRobot], None], code: int, reported: str
) -> None:
    goal = scene.moving()
    cause(scene.robot)
    result = goal.result()
    assert result.error_code == code, result.message
    assert reported in result.message
    # No stop moves a joint far: that which slipped is held `follow_error` off its trajectory.
    assert scene.held() == pytest.approx(scene.robot.angles, abs=0.05 if cause != slip else 0.1)


def test_joint_angles_that_stop_stop_the_motion(scene: Scene) -> None:
    goal = scene.moving()
    scene.robot.publishes_joints = False
    result = goal.result()
    assert result.error_code == Plan.Result.NO_JOINT_STATES
    assert "stopped while moving" in result.message
    assert len(scene.commands.last.points) > 1, "it rests already, by what it was sent"


def test_nothing_begins_with_hot_motors(scene: Scene) -> None:
    scene.robot.degc = 65.0  # not as cool as to begin
    scene.world.until_reported("planner", "heat", "at 65")
    sent = len(scene.commands)
    result = scene.plan().result()
    assert result.error_code == Plan.Result.HOT_JOINTS
    assert result.message.startswith("not begun: joint 'RKneePitch' is at 65 degC")
    assert len(scene.commands) == sent


def test_on_one_foot_a_hot_motor_waits_until_both_carry(scene: Scene) -> None:
    goal = scene.plan("unload_right")
    scene.until_lifted(goal, 0.003)
    scene.robot.degc = 71.0
    result = goal.result()
    assert result.error_code == Plan.Result.HOT_JOINTS, result.message
    assert height(scene.held()) == pytest.approx(0.0, abs=1e-3), "the foot is down"


@pytest.mark.parametrize(
    ("motion", "foot", "stop", "code"),
    [
        ("unload_right", "left", Goal.cancel, Plan.Result.CANCELED),
        ("unload_left", "right", None, Plan.Result.TILTED),
    ],
)
def test_stopped_on_one_foot_the_other_one_is_put_down(
    scene: Scene, motion: str, foot: str, stop: Callable[[Goal], None] | None, code: int
) -> None:
    goal = scene.plan(motion)
    scene.until_lifted(goal, 0.006)
    if stop is None:
        lean(scene.robot)
    else:
        stop(goal)
    result = goal.result()
    assert result.error_code == code, result.message
    advice = f"; the robot stands on its {foot} foot: arm and plan motion 'put_down'"
    assert result.message.endswith(advice)
    assert abs(height(scene.held())) > 0.005, "held at once"
    scene.robot.leaning = 0.0
    scene.world.until(lambda: scene.robot.still)

    refused = scene.plan().result()
    assert refused.error_code == Plan.Result.INFEASIBLE
    assert "put_down" in refused.message
    down = scene.plan("put_down").result()
    assert down.success, down.message
    assert scene.robot.lifted == pytest.approx(0.0, abs=1e-3)


def test_a_motion_of_several_parts_is_not_streamed(scene: Scene) -> None:
    goal = Plan.Goal(motion="unload_right", send=True, stream=True)
    result = scene.world.goal(Plan, "shoe/plan", goal).result()
    assert result.error_code == Plan.Result.BAD_GOAL
    assert "cannot be streamed; ask without stream, or for one of: landmarks" in result.message


def test_a_motion_done_tells_how_warm_it_left_the_motors(scene: Scene) -> None:
    """One message of joint angles that cannot be used on the way changes nothing."""
    goal = scene.plan("unload_right")
    scene.until(goal, lambda: scene.robot.lifted > 0.003)
    scene.robot.publish_garbled_joints()
    result = goal.result()
    assert result.success, result.message
    assert "hottest joint 'RKneePitch' at 40 degC, 28 degC below the limit" in result.message
