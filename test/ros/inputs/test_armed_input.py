from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from std_msgs.msg import Bool

from ros.clock import Clock
from shoecal_ros.common import qos
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.inputs.armed_input import LEASE_S, ArmedInput


@pytest.fixture
def node() -> Iterator[ShoecalNode]:
    rclpy.init()
    node = ShoecalNode("listener")
    node.create_publisher(Bool, "shoe/armed", qos.LATCHED)
    yield node
    node.end()
    rclpy.shutdown()


def test_who_repeats_that_the_robot_is_armed_must_go_on(node: ShoecalNode) -> None:
    clock = Clock()
    armed = ArmedInput(node, clock)
    while armed._subscription.get_publisher_count() == 0:
        rclpy.spin_once(node, timeout_sec=0.01)

    def tell(*, data: bool) -> None:
        armed._hear([Bool(data=data)])

    tell(data=True)
    clock.now += 100.0
    assert (armed.armed, armed.lapsed) == (True, False), "said once, by who is still there"
    tell(data=True)
    clock.now += 0.9 * LEASE_S
    assert (armed.armed, armed.lapsed) == (True, False)
    clock.now += 0.2 * LEASE_S
    assert (armed.armed, armed.lapsed) == (False, True)
    tell(data=True)
    assert (armed.armed, armed.lapsed, armed.disarmings) == (True, False, 0)
    tell(data=False)
    clock.now += 100.0
    assert (armed.armed, armed.lapsed, armed.disarmings) == (False, False, 1)


def test_who_armed_and_left_without_a_word_is_gone_at_once(node: ShoecalNode) -> None:
    armed = ArmedInput(node)
    (publisher,) = [one for one in node.publishers if one.topic_name == "/shoe/armed"]
    publisher.publish(Bool(data=True))
    while not armed.armed:
        rclpy.spin_once(node, timeout_sec=0.01)
    assert (armed.reported, armed.lapsed) == (True, False)
    node.destroy_publisher(publisher)
    while armed.armed:
        rclpy.spin_once(node, timeout_sec=0.01)
    assert (armed.reported, armed.lapsed, armed.disarmings) == (True, True, 0)


def test_who_disarms_and_arms_at_once_is_heard_to_disarm(node: ShoecalNode) -> None:
    armed = ArmedInput(node)
    publisher = node.create_publisher(Bool, "shoe/armed", qos.ARMED)
    while publisher.get_subscription_count() == 0:
        rclpy.spin_once(node, timeout_sec=0.01)
    for data in (True, False, True):
        publisher.publish(Bool(data=data))
    while not armed.armed:
        rclpy.spin_once(node, timeout_sec=0.01)
    assert armed.disarmings == 1
