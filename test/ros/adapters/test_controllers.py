"""The adapter to controllers that go on by themselves with what they were sent, over real DDS."""

from __future__ import annotations

import time

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from std_srvs.srv import Trigger

from ros.adapters.conftest import Adapted, Begin
from ros.adapters.motions import WAY, Knee, squat
from shoecal_ros.adapters.goal import PATIENCE_S
from shoecal_ros.common.codes import Code

NODE = "controller_adapter"
OTHERS = "LShoulderPitch, RShoulderPitch"
INTERFACES: dict[str, dict[str, object]] = {
    "topic": {"controller": "legs", "interface": "topic"},
    "action": {"controller": "legs", "others": OTHERS},
}
GOES_ON = "legs was asked to stop and goes on; use the robot's emergency stop"


@pytest.fixture(params=INTERFACES)
def robot(request: pytest.FixtureRequest, begin: Begin) -> Adapted:
    return begin(request.param, NODE, **INTERFACES[request.param])


def behind_action(begin: Begin, kind: str) -> Adapted:
    return begin(kind, NODE, **INTERFACES["action"])


def moving(robot: Adapted, duration: float) -> Knee:
    """Armed, and at the beginning of a motion."""
    knee = Knee(robot)
    robot.arm()
    robot.command(squat(duration, way=0.3))
    robot.world.until(lambda: knee.way > 0.005)
    return knee


def squats(robot: Adapted, knee: Knee) -> None:
    """A motion is followed to its end."""
    robot.command(squat(0.5))
    robot.world.until(lambda: abs(knee.way - WAY) < 1e-6)


def code(reported: DiagnosticStatus) -> str:
    return str(next(value.value for value in reported.values if value.key == "code"))


def test_started_again_it_takes_the_next_motion(robot: Adapted) -> None:
    knee = moving(robot, 60.0)
    robot.kill_adapter()
    robot.start_adapter()
    robot.world.until(knee.rests)
    assert 0.0 < knee.way < 0.29
    robot.until_well("armed")
    squats(robot, knee)


def test_killed_it_leaves_the_controller_half_a_second_to_go_on_with(robot: Adapted) -> None:
    """Sixty seconds of a motion were asked for, and no adapter comes back."""
    knee = moving(robot, 60.0)
    robot.kill_adapter()
    way = knee.way
    robot.world.until(knee.rests)
    # A squat of 0.3 rad in 60 s: what is left of a goal, and what was on its way here.
    assert knee.way - way < 0.3 / 60.0 * 10.0


def test_a_motion_in_many_goals_comes_to_its_end(robot: Adapted) -> None:
    knee = Knee(robot)
    robot.arm()
    robot.send(squat(3.0))
    robot.world.until(lambda: abs(knee.way - WAY) < 1e-6)


def test_started_again_where_nobody_has_armed_it_sends_nothing(robot: Adapted) -> None:
    knee = moving(robot, 60.0)
    robot.kill_adapter()
    robot.say(armed=False)
    robot.world.until(knee.rests)
    way = knee.way
    robot.start_adapter()
    robot.until_well("not armed")
    robot.settle()
    assert knee.rests()
    assert knee.way == pytest.approx(way, abs=1e-9)


def test_a_goal_that_is_not_cancelled_is_told_and_asked_to_end_again(begin: Begin) -> None:
    robot = behind_action(begin, "refusing_action")
    knee = moving(robot, 120.0)
    robot.arm(False)
    assert code(robot.until_reported(GOES_ON)) == Code.CONTROLLER_GOES_ON
    assert robot.world.call(Trigger, "robot/accept_cancel", Trigger.Request()).success
    robot.world.until(knee.rests)
    assert knee.way < 0.29
    robot.until_well("not armed")


def test_a_goal_that_is_not_cancelled_may_end_by_itself(begin: Begin) -> None:
    robot = behind_action(begin, "settling_action")
    knee = moving(robot, 60.0)
    robot.arm(False)
    robot.until_reported(GOES_ON)
    robot.until_well("not armed")
    assert knee.way < 0.29


def test_a_controller_that_does_not_answer_is_asked_again(begin: Begin) -> None:
    robot = behind_action(begin, "hanging_action")
    knee = moving(robot, 60.0)
    robot.arm(False)
    robot.world.until(knee.rests)
    assert knee.way < 0.29


@pytest.mark.parametrize("kind", ["action", "stuck_action"])
def test_a_goal_that_the_controller_does_not_know_has_ended(kind: str, begin: Begin) -> None:
    robot = behind_action(begin, kind)
    moving(robot, 60.0)
    if kind == "stuck_action":
        robot.arm(False)
        robot.until_reported(GOES_ON)
    robot.world.kill("robot")
    if kind == "action":
        # Well before as after: what lies between has to be seen.
        robot.until_reported("no joint angles")
    robot.start_robot()
    robot.until_well("not armed" if kind == "stuck_action" else "armed")
    robot.arm(False)
    # Where it were supposed to go on, that would be told by then.
    end = time.monotonic() + 2.0 * PATIENCE_S
    robot.world.until(lambda: time.monotonic() > end)
    robot.until_well("not armed")


def test_a_controller_that_refuses_is_told(begin: Begin) -> None:
    robot = begin("action", "controller_adapter", controller="legs")
    robot.arm()
    robot.command(squat(0.5))
    reported = robot.until_reported("legs refused the trajectory")
    assert {"rate_hz", "age_s"} <= {value.key for value in reported.values}


def test_a_controller_that_takes_longer_is_stopped_all_the_same(begin: Begin) -> None:
    robot = begin("slow_action", "controller_adapter", controller="legs", others=OTHERS)
    knee = Knee(robot)
    robot.arm()
    robot.command(squat(0.5))
    # Long after the time that the motion should have taken.
    robot.world.until(lambda: knee.way > 0.15 * WAY)
    robot.arm(False)
    robot.world.until(knee.rests)
    assert knee.way < 0.9 * WAY


def test_before_anybody_has_said_whether_the_robot_is_armed_that_is_told(begin: Begin) -> None:
    robot = begin("topic", NODE, armed_by_test=False, **INTERFACES["topic"])
    assert robot.until_reported("no node publishes whether it is").level == DiagnosticStatus.OK


def test_a_controller_that_is_not_there_is_told(begin: Begin) -> None:
    robot = begin("topic", "controller_adapter", controller="arms", interface="topic")
    robot.arm()
    robot.send(squat(0.5))
    robot.world.until_reported(
        "controller_adapter", "robot", "no node offers /arms/joint_trajectory; start the controller"
    )


@pytest.mark.parametrize("interface", INTERFACES)
def test_a_controller_that_is_not_there_is_told_before_it_is_needed(
    interface: str, begin: Begin
) -> None:
    parameters = {**INTERFACES[interface], "controller": "arms"}
    reported = begin(interface, NODE, **parameters).until_reported("no node offers /arms/")
    assert reported.level == DiagnosticStatus.WARN
    assert code(reported) == Code.DRIVER_MISSING
