"""Adapters between trajectories and robots that are stand-ins, over real DDS.

What is the same for all of them: nothing moves unarmed, trajectories are followed, a robot that may
move no more stops.
"""

from __future__ import annotations

import time
from dataclasses import fields

import numpy as np
import pytest
from sensor_msgs.msg import Temperature

from ros.adapters.conftest import Adapted, Begin
from ros.adapters.motions import KNEE, WAY, Knee, bent, squat
from ros.bodies import nao
from ros.policy import Rights, allowed, used
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.common.health import Level
from shoecal_ros.common.hold import LONGEST_S, hold

OTHERS = "LShoulderPitch, RShoulderPitch"
KINDS: dict[str, tuple[str, str, dict[str, object]]] = {
    "nao_lola": ("nao_lola", "nao_lola_adapter", {}),
    "naoqi": ("naoqi", "naoqi_adapter", {}),
    "topic": ("topic", "controller_adapter", {"controller": "legs", "interface": "topic"}),
    "action": ("action", "controller_adapter", {"controller": "legs", "others": OTHERS}),
}
CONTROLLER = "joint_trajectory_controller"
DRIVERS = {
    "nao_lola": "no node subscribes to /effectors/joint_positions; start nao_lola",
    "naoqi": "no node subscribes to /joint_angles; start naoqi_driver2",
    "topic": "no node offers /legs/joint_trajectory; start the controller",
    "action": "no node offers /legs/follow_joint_trajectory; start the controller",
}


@pytest.fixture(params=KINDS)
def adapter(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def robot(adapter: str, begin: Begin) -> Adapted:
    kind, node, parameters = KINDS[adapter]
    return begin(kind, node, **parameters)


def test_it_follows_when_armed_and_stops_when_no_more(adapter: str, robot: Adapted) -> None:
    world, node, knee = robot.world, KINDS[adapter][1], Knee(robot)
    robot.send(squat(0.5))
    world.until_reported(node, "robot", "trajectory refused: not armed: call the service shoe/arm")
    assert knee.way == 0.0
    robot.arm()
    robot.command(squat(0.5))
    world.until(lambda: abs(knee.way - WAY) < 1e-6)
    world.until(lambda: world.diagnosis(node, "robot").message == "armed")
    # Back, slowly; in the middle of it whoever armed the robot takes it back and says no more.
    robot.command(squat(60.0, way=-0.3, begin=WAY))
    world.until(lambda: knee.way < WAY - 0.003)
    robot.arm(False)
    world.until_reported(node, "robot", "not armed")
    world.until(knee.rests)


def test_armed_again_at_once_it_does_not_go_on(adapter: str, robot: Adapted) -> None:
    knee = Knee(robot)
    robot.arm()
    robot.command(squat(60.0, way=-0.3))
    robot.world.until(lambda: knee.way < 0.0)
    robot.arm(False, True)
    robot.world.until(knee.rests)
    robot.command(squat(0.5))
    robot.world.until(lambda: abs(knee.way - WAY) < 1e-6)


@pytest.mark.parametrize("duration", [0.5, 3.0])
def test_what_begins_elsewhere_is_refused(robot: Adapted, duration: float) -> None:
    """No piece of a motion goes on without a robot that was left behind."""
    knee = Knee(robot)
    robot.arm()
    robot.until_well("armed")
    robot.send(squat(duration, begin=0.06))
    robot.until_reported("trajectory refused: joint 'LKneePitch' begins 0.06 rad from where it is")
    assert knee.way == 0.0
    robot.command(squat(0.5))
    robot.world.until(lambda: abs(knee.way - WAY) < 1e-6)


def test_a_hold_counts_while_the_driver_is_gone(adapter: str, robot: Adapted) -> None:
    """Else one that comes back would be told to be where the motion has come to meanwhile."""
    knee = Knee(robot)
    robot.arm()
    robot.command(squat(30.0, way=0.3))
    robot.world.until(lambda: knee.way > 0.005)
    robot.world.stop("robot")
    robot.until_reported(DRIVERS[adapter])
    robot.settle()
    robot.send(hold(nao(), bent(knee.way), 0.5))
    robot.until_reported("trajectory refused: no node")
    robot.start_robot()
    robot.until_reported("armed")
    robot.world.until(lambda: robot.reported.level < bytes([Level.ERROR]))
    robot.world.until(knee.rests)
    assert knee.way < 0.05


def test_a_command_to_hold_is_followed_to_its_end(adapter: str, robot: Adapted) -> None:
    """Whoever disarms a robot that is coming to rest lets it do so."""
    world, knee = robot.world, Knee(robot)
    robot.arm()
    robot.command(squat(30.0, way=0.3))
    world.until(lambda: knee.way > 0.02)
    robot.command(hold(nao(), bent(0.01), 4.0))
    robot.arm(False)
    world.until(lambda: abs(knee.way - 0.01) < 1e-6)


def test_what_takes_long_to_hold_is_stopped_like_a_motion(adapter: str, robot: Adapted) -> None:
    world, knee, takes_s = robot.world, Knee(robot), LONGEST_S + 1.0
    robot.arm()
    robot.command(hold(nao(), bent(0.19), takes_s))
    robot.arm(False)
    end = time.monotonic() + takes_s + 1.0
    world.until(lambda: time.monotonic() > end)
    assert knee.way < 0.18


def test_not_armed_a_command_to_hold_stops_the_robot_and_never_moves_it(
    adapter: str, robot: Adapted
) -> None:
    """Whoever disarms a moving robot stops it just after that; nobody walks it by such commands."""
    world, knee = robot.world, Knee(robot)
    robot.command(hold(nao(), bent(0.19), 0.01))
    assert knee.rests()
    robot.arm()
    robot.command(squat(30.0, way=0.3))
    world.until(lambda: knee.way > 0.02)
    robot.arm(False)
    robot.until_well("not armed")
    robot.command(hold(nao(), bent(0.19), 0.01))
    world.until(knee.rests)
    rest = knee.way
    assert 0.0 < rest < 0.1
    for _ in range(5):
        robot.command(hold(nao(), bent(knee.way + 0.19), 0.01))
        assert knee.rests()
    assert knee.way == pytest.approx(rest, abs=1e-9)


def test_an_adapter_that_ends_leaves_no_robot_on_its_way(adapter: str, robot: Adapted) -> None:
    world, node, knee = robot.world, KINDS[adapter][1], Knee(robot)
    robot.arm()
    robot.command(squat(20.0, way=0.5))
    world.until(lambda: knee.way > 0.05)
    assert world.stop(node) == 0
    world.until(knee.rests)
    assert knee.way < 0.4


def test_lola_s_motors_tell_their_heat(begin: Begin) -> None:
    robot = begin("nao_lola", "nao_lola_adapter", heat_rate=20.0)
    heard = robot.world.receive(Temperature, "joint_temperatures", qos.LIVE)
    robot.world.until(lambda: len(heard) >= 25)
    reported = {message.header.frame_id: message.temperature for message in heard.messages}
    robot.world.until(lambda: len({m.header.frame_id for m in heard.messages}) == 25)
    reported = {message.header.frame_id: message.temperature for message in heard.messages}
    assert reported["HeadYaw"] == 30.0
    assert reported["LHipYawPitch"] == 37.0
    assert reported["RHipRoll"] == 43.0


def test_a_driver_that_is_gone_is_told(adapter: str, robot: Adapted) -> None:
    assert robot.world.stop("robot") == 0
    robot.until_reported(DRIVERS[adapter])


def test_a_refusal_hides_nothing_that_lasts(adapter: str, robot: Adapted) -> None:
    robot.send(squat(0.5))
    robot.until_reported("trajectory refused: not armed")
    robot.world.kill("robot")
    reported = robot.until_reported("no joint angles for")
    codes = {value.key: value.value for value in reported.values}
    assert codes["code"] == Code.JOINTS_STALE


def test_a_refusal_is_forgotten(begin: Begin) -> None:
    robot = begin("naoqi", "naoqi_adapter")
    robot.send(squat(0.5))
    robot.until_reported("trajectory refused: not armed")
    robot.world.until(lambda: robot.reported.message == "not armed")


def test_motions_beyond_limits_are_refused(begin: Begin) -> None:
    robot = begin("naoqi", "naoqi_adapter")
    knee = Knee(robot)
    robot.arm()
    robot.until_well("armed")
    robot.send(squat(1.0, way=3.0))
    robot.world.until_reported("naoqi_adapter", "robot", "beyond its limits")
    assert knee.way == 0.0


@pytest.mark.parametrize(
    ("motion", "reported"),
    [
        (JointTrajectory((KNEE,), np.array([0.02]), np.array([[1.8]])), "joint_speed 1 rad/s"),
        (JointTrajectory((KNEE,), np.array([0.0, 5.0]), np.array([[1.8], [1.8]])), "joint_speed"),
        (squat(0.05, way=0.05), "joint_speed"),
        (
            JointTrajectory((KNEE,), np.array([0.0, 0.05]), np.array([[0.8], [0.825]])),
            "joint_acceleration 20 rad/s^2",
        ),
    ],
    ids=["one point far off", "begins far off", "fast", "jerky"],
)
def test_motions_faster_than_any_of_ours_are_refused(
    motion: JointTrajectory, reported: str, begin: Begin
) -> None:
    robot = begin("nao_lola", "nao_lola_adapter")
    knee = Knee(robot)
    robot.arm()
    robot.until_well("armed")
    robot.send(motion)
    robot.until_reported("trajectory refused: joint 'LKneePitch' would reach")
    robot.until_reported(reported)
    assert knee.way == 0.0


def test_what_waited_on_its_way_is_refused(adapter: str, robot: Adapted) -> None:
    """By its stamp, of the clock of `joint_states`."""
    knee = Knee(robot)
    robot.arm()
    robot.until_well("armed")
    stamp_ns = time_from_ros(knee.stamp) - 1_000_000_000
    robot.send(squat(0.5), stamp_ns)
    robot.until_reported("s old by its stamp (at most 0.2 s)")
    assert knee.way == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_the_security_policy_allows_what_they_make(kind: str, begin: Begin) -> None:
    driver, node, parameters = KINDS[kind]
    expected = _rights(allowed()[node])
    if node == "controller_adapter":
        # As it is named where nobody names it otherwise; one of the two ways is used.
        parameters = {**parameters, "controller": CONTROLLER}
        unused = {"action": "publish", "topic": "call"}[kind]
        expected[unused] -= {
            f"/{CONTROLLER}/joint_trajectory",
            f"/{CONTROLLER}/follow_joint_trajectory",
        }
    robot = begin(driver, node, **parameters)
    robot.world.until(lambda: _rights(used(robot.world.node, node)) == expected)


def _rights(rights: Rights) -> dict[str, set[str]]:
    """Without simulated time, which no robot has."""
    return {rule.name: rights.allow(rule.name) - {"/clock"} for rule in fields(Rights)}
