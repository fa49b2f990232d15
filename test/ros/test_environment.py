"""Processes that are started with `ros_environment()` have ROS 2, the messages and the nodes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from shoecal_msgs.action import ReachSupport
from shoecal_msgs.msg import DoubleSupport, ShoeVoltages

from ros.introduction import Introduction
from shoecal_core.workspace import ros_environment

ROBOT = Path(__file__).with_name("echo_robot.py")
TIMEOUT_S = 120.0

from_wheels = pytest.mark.skipif(
    not Path(sys.prefix, "share/ament_index/resource_index/packages/rclpy").is_file(),
    reason="ROS 2 is not from wheels here",
)


@pytest.fixture
def node() -> Iterator[Node]:
    rclpy.init()
    node = Node("environment_test")
    yield node
    node.destroy_node()
    rclpy.shutdown()


@pytest.fixture
def robot() -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, ROBOT], env=ros_environment(), stdout=subprocess.PIPE, text=True
    )
    with process:
        yield process
        process.terminate()
        try:
            process.wait(TIMEOUT_S)
        finally:
            process.kill()


def _be_known(node: Node) -> None:
    introduction = Introduction(node, "echo_robot")
    while not introduction.done:
        rclpy.spin_once(node, timeout_sec=0.05)


def test_messages_reach_another_process(node: Node, robot: subprocess.Popen[str]) -> None:
    publisher = node.create_publisher(ShoeVoltages, "shoe/voltages", 1)
    _be_known(node)
    publisher.publish(ShoeVoltages(sequence=7, cell=["left/front"], voltage=[0.25], status=[0]))
    assert robot.stdout is not None
    assert robot.stdout.readline().split() == ["7", "left/front", "0.25"]


@pytest.mark.usefixtures("robot")
def test_an_action_is_done_by_another_process(node: Node) -> None:
    client = ActionClient(node, ReachSupport, "robot/reach_support")
    assert client.wait_for_server(TIMEOUT_S)
    _be_known(node)
    heard: list[float] = []
    goal = ReachSupport.Goal(support=DoubleSupport(dx=0.02, dy=-0.1, dtheta=0.1))
    sent = client.send_goal_async(goal, lambda message: heard.append(message.feedback.progress))
    rclpy.spin_until_future_complete(node, sent, timeout_sec=TIMEOUT_S)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result, timeout_sec=TIMEOUT_S)
    assert result.result().result.message == "0.02 -0.1 0.1"
    assert heard == [0.5]


@from_wheels
def test_the_interpreter_starts_once() -> None:
    program = "import os, sys; print(os.environ['LD_LIBRARY_PATH'])"
    environment = ros_environment()
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stdout.strip() == environment["LD_LIBRARY_PATH"]


@from_wheels
def test_another_installation_of_ros_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    index = tmp_path / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "rclpy").touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.setenv("LD_LIBRARY_PATH", f"{tmp_path}/lib{os.pathsep}/usr/local/lib")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}/lib/python3/site-packages{os.pathsep}/opt/mine")
    environment = ros_environment()
    assert str(tmp_path) not in environment["AMENT_PREFIX_PATH"]
    assert str(tmp_path) not in environment["LD_LIBRARY_PATH"]
    assert environment["LD_LIBRARY_PATH"].endswith(f"{os.pathsep}/usr/local/lib")
    assert environment["PYTHONPATH"] == "/opt/mine"


@from_wheels
def test_calling_it_twice_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    once = ros_environment()
    for name, value in once.items():
        monkeypatch.setenv(name, value)
    assert ros_environment() == once


def test_the_field_of_discovery_stays_as_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    assert ros_environment()["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
