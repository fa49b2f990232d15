from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String

from shoecal_ros.common import qos
from shoecal_ros.common.callback_lock import CallbackLock
from shoecal_ros.common.realtime_executor import RealtimeExecutor

TIMEOUT_S = 120.0


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.005)


@pytest.fixture
def node() -> Iterator[Node]:
    context = rclpy.Context()
    rclpy.init(context=context)
    node = Node(
        "quick", context=context, parameter_overrides=[Parameter("use_sim_time", value=False)]
    )
    yield node
    node.destroy_node()
    rclpy.shutdown(context=context)


def talk(node: Node, quick: RealtimeExecutor, heard: list[Any], count: int) -> None:
    publisher = node.create_publisher(String, "words", qos.RAW)
    until(lambda: publisher.get_subscription_count() > 0)
    for index in range(count):
        publisher.publish(String(data=str(index)))
    until(lambda: len(heard) == count or quick.error is not None)


def test_everything_is_heard_in_order_without_an_executor(node: Node) -> None:
    quick, heard = RealtimeExecutor(node, CallbackLock()), list[Any]()
    quick.subscribe(String, "words", heard.extend, qos.RAW)
    quick.start()
    talk(node, quick, heard, 500)
    quick.close()
    assert [message.data for message in heard] == [str(index) for index in range(500)]


def test_nothing_is_handed_over_out_of_turn(node: Node) -> None:
    turn, heard = CallbackLock(), list[bool]()
    quick = RealtimeExecutor(node, turn)
    quick.subscribe(
        String, "words", lambda batch: heard.extend(turn._held.locked() for _ in batch), qos.RAW
    )
    quick.start()
    talk(node, quick, heard, 50)
    with turn:
        talk_later = node.create_publisher(String, "words", qos.RAW)
        until(lambda: talk_later.get_subscription_count() > 0)
        talk_later.publish(String(data="not now"))
        time.sleep(0.2)  # nothing can be awaited: nothing may happen
        assert len(heard) == 50
    until(lambda: len(heard) == 51)
    quick.close()
    assert all(heard)


def test_the_executor_leaves_them_alone(node: Node) -> None:
    quick, heard = RealtimeExecutor(node, CallbackLock()), list[Any]()
    quick.subscribe(String, "words", heard.extend, qos.RAW)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    publisher = node.create_publisher(String, "words", qos.RAW)
    until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(String(data="one"))
    for _ in range(20):
        executor.spin_once(timeout_sec=0.01)
    assert heard == []
    quick.start()
    until(lambda: len(heard) == 1)
    quick.close()
    executor.shutdown()


def test_what_a_callback_fails_with_is_kept(node: Node) -> None:
    def fail(batch: list[Any]) -> None:
        raise ValueError(batch[0].data)

    quick = RealtimeExecutor(node, CallbackLock())
    quick.subscribe(String, "words", fail, qos.RAW)
    quick.start()
    talk(node, quick, [], 1)
    assert isinstance(quick.error, ValueError)
    quick.close()


def test_with_nothing_to_hear_there_is_no_thread(node: Node) -> None:
    before = threading.active_count()
    quick = RealtimeExecutor(node, CallbackLock())
    quick.start()
    assert threading.active_count() == before
    quick.close()
