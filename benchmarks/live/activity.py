"""What goes on meanwhile, again and again until it is ended.

    python activity.py solving | recording | planning

Prints a line when it is under way.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from shoecal_msgs.action import Calibrate, Diagnose, Plan, ReachSupport
from std_msgs.msg import Bool

from live import session
from live.spinning import spin
from shoecal_ros.calibrator.run_series import PLAN_ACTION, REACH_ACTION
from shoecal_ros.common import qos

FEEDBACK_S = 0.2
UNDER_WAY = "under way"
"""The line."""


class Repeated(Node):
    """Sends a goal anew whenever it has ended."""

    def __init__(self, kind: type[Any], name: str, goal: Any, begun: Callable[[Any], bool]) -> None:
        super().__init__("activity")
        self._client = ActionClient(self, kind, name)
        self._name, self._goal, self._begun = name, goal, begun
        self._told = False
        self._ended = threading.Event()

    def go_on(self) -> None:
        """Blocks; for a thread."""
        self._client.wait_for_server()
        while rclpy.ok():
            self._ended.clear()
            sent = self._client.send_goal_async(self._goal, self._hear)
            sent.add_done_callback(self._await_result)
            self._ended.wait()

    def _await_result(self, sent: Future) -> None:
        sent.result().get_result_async().add_done_callback(self._end)

    def _hear(self, message: Any) -> None:
        if not self._told and self._begun(message.feedback):
            self._told = True
            print(UNDER_WAY, flush=True)

    def _end(self, future: Future) -> None:
        result = future.result().result
        if not result.success:
            print(f"{self._name}: {result.message}", file=sys.stderr, flush=True)
            time.sleep(1.0)
        self._ended.set()


class Recorded(Repeated):
    """A robot that is wherever it is wanted, and in a motion that never ends."""

    def __init__(self) -> None:
        super().__init__(
            Calibrate, "shoe/calibrate", Calibrate.Goal(supports=2, train=2, seed=1),
            lambda told: bool(told.stage == "moving"),
        )  # fmt: skip
        self._armed = self.create_publisher(Bool, "shoe/armed", qos.LATCHED)
        self._armed.publish(Bool(data=True))
        self._servers = [
            ActionServer(self, kind, name, do, cancel_callback=lambda _: CancelResponse.ACCEPT)
            for kind, name, do in (
                (ReachSupport, REACH_ACTION, self._reach), (Plan, PLAN_ACTION, self._move),
            )
        ]  # fmt: skip

    def _reach(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        goal.succeed()
        return ReachSupport.Result(success=True)

    def _move(self, goal: ServerGoalHandle) -> Plan.Result:
        while rclpy.ok() and not goal.is_cancel_requested:
            goal.publish_feedback(Plan.Feedback(phase="moving"))
            time.sleep(FEEDBACK_S)
        goal.canceled()
        return Plan.Result(success=False, error_code=Plan.Result.CANCELED, message="cancelled")


def make(activity: str) -> Repeated:
    if activity == "solving":
        goal = Diagnose.Goal(session=session.NAME, seed=-1)
        return Repeated(
            Diagnose, "shoe/diagnose", goal, lambda told: bool(told.phase == "diagnosing")
        )
    if activity == "planning":
        goal = Plan.Goal(motion="landmarks")
        return Repeated(Plan, PLAN_ACTION, goal, lambda _: True)
    return Recorded()


def begun() -> Node:
    """The node, already at work."""
    node = make(sys.argv[1])
    threading.Thread(target=node.go_on, daemon=True).start()
    return node


if __name__ == "__main__":
    spin(begun, threads=4)
