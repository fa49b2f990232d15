from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PointStamped
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState

from ros.bodies import ODD, ODD_SHOE, nao
from ros.world import Received, World
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros, point_from_ros


def message(index: int) -> JointState:
    robot = nao()
    angles = robot.posture + 0.01 * np.sin(index + np.arange(len(robot.posture)))
    return joints_to_ros(JointSample(10**9 + index * 10**7, robot.joint_names, angles))


def test_com_and_cop_of_every_sample(world: World) -> None:
    world.start("model")
    com = world.receive(PointStamped, "shoe/model/com", qos.RAW)
    cop = world.receive(PointStamped, "shoe/model/cop", qos.RAW)
    publisher = world.publisher(JointState, "joint_states")
    sent = [message(index) for index in range(20)]
    # One at a time: live topics keep but the last few.
    for count, one in enumerate(sent, 1):
        publisher.publish(one)
        world.until(partial(_both, com, cop, count))
    states = Kinematics(nao()).states(np.array([one.position for one in sent]))
    for index, one in enumerate(sent):
        assert com.messages[index].header.stamp == one.header.stamp
        assert com.messages[index].header.frame_id == "base_link"
        assert cop.messages[index].header.frame_id == "l_sole"
        np.testing.assert_allclose(
            point_from_ros(com.messages[index]), states.com_in_base[index], atol=1e-12
        )
        np.testing.assert_allclose(
            point_from_ros(cop.messages[index])[:2], states.cop[index, 0], atol=1e-12
        )


def _both(one: Received, other: Received, count: int) -> bool:
    return len(one) >= count and len(other) >= count


def test_joints_that_do_not_match_are_told_once(world: World) -> None:
    world.start("model", {"robot_file": ODD, "shoe_file": ODD_SHOE})
    publisher = world.publisher(JointState, "joint_states")
    for index in range(50):
        publisher.publish(message(index))
    status = world.until_reported("model", "joints", "needs joint(s)")
    assert "left_hip_yaw" in status.message
    assert "LKneePitch" in status.message
    assert status.level == b"\x02"
    world.stop("model")
    assert world.output("model").count("needs joint(s)") == 1


def test_a_node_that_is_started_twice_is_told(world: World) -> None:
    world.start("model")
    world.start("model", name="twin")
    reported = world.until_reported(
        "model", "peers", "another node named '/model' publishes /shoe/model/"
    )
    assert reported.level == b"\x02"
    assert "stop one of them" in reported.message
    world.stop("twin")
    world.until_reported("model", "peers", "no conflict on this node's topics")


def test_a_second_sender_is_a_warning_until_it_contradicts(world: World) -> None:
    world.start("model")
    com = world.receive(PointStamped, "shoe/model/com", qos.LIVE)
    own = world.publisher(JointState, "joint_states")
    other = world.companion("player").create_publisher(JointState, "joint_states", qos.RAW)
    same, away = message(0).position, [0.5 * angle for angle in nao().upper]
    stamp = [10**9]

    def tell(publisher: Publisher, angles: Sequence[float]) -> None:
        stamp[0] += 5_000_000
        names = nao().joint_names
        publisher.publish(joints_to_ros(JointSample(stamp[0], names, np.array(angles))))

    def reported(subject: str, text: str, angles: Sequence[float]) -> DiagnosticStatus:
        def receive() -> bool:
            tell(own, same)
            tell(other, angles)
            status = world.diagnosis("model", subject)
            return status is not None and text in status.message

        world.until(receive)
        return world.diagnosis("model", subject)

    def used() -> None:
        count = len(com)

        def comes() -> bool:
            tell(own, same)
            return len(com) > count

        world.until(comes)

    # Its name is known a little later than it itself.
    status = reported("peers", "'/player'", same)
    assert "publish /joint_states; where they send the same joints" in status.message
    assert status.level == b"\x01"
    assert reported("joints", "joint angles come", same).level == b"\x00"
    used()
    status = reported("joints", "joint angles run to and fro", away)
    assert "'/player'" in status.message
    assert status.level == b"\x02"

    def mix(times: int) -> int:
        """Let both tell, one after the other; messages heard in the end."""
        for _ in range(times):
            tell(own, same)
            tell(other, away)
            # Once it answers, it has taken what was told before.
            world.until_discovered_by("model")
        return len(com)

    # What was under way comes first.
    count = mix(10)
    assert mix(50) == count, "nothing is made of either"
    used()


def test_names_follow_namespaces_and_remapping(world: World) -> None:
    world.start("model", None, "-r", "__ns:=/lab", "-r", "joint_states:=robot/joints")
    cop = world.receive(PointStamped, "/lab/shoe/model/cop", qos.LIVE)
    publisher = world.publisher(JointState, "/lab/robot/joints")
    publisher.publish(message(0))
    world.until(lambda: len(cop))


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"robot_file": "/not/there.yaml"}, "/not/there.yaml: cannot be read"),
        ({"stale_s": -1.0}, "stale_s: must be at least 0.01 s, got -1 s"),
        ({"stale_s": "soon"}, "stale_s: expected a number, got 'soon'"),
    ],
)
def test_bad_parameters_end_the_node_with_one_line(
    world: World, parameters: dict[str, object], problem: str
) -> None:
    world.start("model", parameters)
    assert world.ended("model") == 1
    (line,) = world.output("model").splitlines()
    assert problem in line
