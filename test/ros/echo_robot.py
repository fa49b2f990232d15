"""A process of its own that repeats what it hears: the other side of test_environment."""

from __future__ import annotations

import contextlib

import rclpy
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from shoecal_msgs.action import ReachSupport
from shoecal_msgs.msg import ShoeVoltages


def repeat(message: ShoeVoltages) -> None:
    print(message.sequence, *message.cell, *message.voltage, flush=True)


def reach(goal: ServerGoalHandle) -> ReachSupport.Result:
    support = goal.request.support
    goal.publish_feedback(ReachSupport.Feedback(progress=0.5))
    goal.succeed()
    return ReachSupport.Result(success=True, message=f"{support.dx} {support.dy} {support.dtheta}")


def main() -> None:
    rclpy.init()
    node = Node("echo_robot")
    node.create_subscription(ShoeVoltages, "shoe/voltages", repeat, 1)
    ActionServer(node, ReachSupport, "robot/reach_support", reach)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
