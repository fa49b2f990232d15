"""A process of its own that repeats what it hears: the other side of test_environment."""

from __future__ import annotations

import signal
from threading import Event

import rclpy
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
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
    # The node leaves before the middleware does: nobody shall find a robot that has gone.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    asked_to_end = Event()
    signal.signal(signal.SIGTERM, lambda *_: asked_to_end.set())
    node = Node("echo_robot")
    node.create_subscription(ShoeVoltages, "shoe/voltages", repeat, 1)
    server = ActionServer(node, ReachSupport, "robot/reach_support", reach)
    while not asked_to_end.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    server.destroy()
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
