"""Talks to the running nodes: waits, arms, calibrates, sees that the result is live."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from itertools import pairwise
from types import TracebackType
from typing import Any, Self

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from shoecal_msgs.action import Calibrate
from std_srvs.srv import SetBool

from shoecal_core.errors import ShoecalError
from shoecal_ros.common import qos
from shoecal_ros.common.end_asked import EndAsked
from shoecal_ros.demonstration.processes import Nodes

START_S = 120.0
ANSWER_S = 20.0
SILENCE_S = 120.0
"""Wall-clock time without any sign of the calibration."""
LIVE_MESSAGES = 100


class DemoError(ShoecalError):
    """A demo that did not come to its end."""


class Conductor:
    """The demo's own node.

    Ctrl-C raises KeyboardInterrupt between two messages: in the midst of one it would look like
    another error.
    """

    def __init__(self, nodes: Nodes, domain: int) -> None:
        self._nodes = nodes
        self._reported: dict[str, str] = {}
        self._asked = EndAsked()
        with ExitStack() as undo:
            undo.callback(self._asked.close)
            context = rclpy.Context()
            rclpy.init(
                args=[],
                context=context,
                domain_id=domain,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            undo.callback(rclpy.shutdown, context=context)
            self._node = Node("demo", context=context)
            undo.callback(self._node.destroy_node)
            self._executor = SingleThreadedExecutor(context=context)
            undo.callback(self._executor.shutdown)
            self._executor.add_node(self._node)
            self._node.create_subscription(
                DiagnosticArray, "diagnostics", self._hear, qos.DIAGNOSTICS
            )
            self._undo = undo.pop_all()

    def wait_for_nodes(self) -> None:
        """Until the planner is ready and joint angles and voltages come."""
        wanted = {
            "planner: planning": "ready",
            "calibrator: joints": "joints come",
            "calibrator: voltages": "voltages come",
        }

        def missing() -> list[str]:
            return [
                f"{name}: {self._reported.get(name, 'not there yet')}"
                for name, text in wanted.items()
                if self._reported.get(name) != text
            ]

        self._until(
            lambda: not missing(),
            START_S,
            lambda: f"the nodes are not ready ({'; '.join(missing())})",
        )

    def arm(self) -> None:
        """Allow the robot to move."""
        client = self._node.create_client(SetBool, "shoe/arm")
        self._until(client.service_is_ready, ANSWER_S, lambda: "no node offers shoe/arm")
        answer = client.call_async(SetBool.Request(data=True))
        self._until(answer.done, ANSWER_S, lambda: "shoe/arm does not answer")

    def calibrate(
        self, goal: Calibrate.Goal, feedback: Callable[[Calibrate.Feedback], None]
    ) -> Calibrate.Result:
        """Run a self-calibration to its end.

        Raises:
            DemoError: when it fails, with its message.
        """
        client = ActionClient(self._node, Calibrate, "shoe/calibrate")
        self._until(client.server_is_ready, ANSWER_S, lambda: "no node offers shoe/calibrate")
        heard = time.monotonic()

        def receive(message: Any) -> None:
            nonlocal heard
            heard = time.monotonic()
            feedback(message.feedback)

        sent = client.send_goal_async(goal, receive)
        self._until(sent.done, ANSWER_S, lambda: "shoe/calibrate does not answer")
        answer = sent.result().get_result_async()
        while not answer.done():
            self._spin()
            if time.monotonic() - heard > SILENCE_S:
                raise DemoError(f"nothing heard of the calibration for {SILENCE_S:g} s")
        result = answer.result().result
        if not result.success:
            raise DemoError(f"the self-calibration ended: {result.message}")
        return result

    def see_live(self) -> None:
        """Until the calibrated CoP has come many times, each later than the one before.

        Raises:
            DemoError: when it does not come, or time stands still.
        """
        stamps: list[tuple[int, int]] = []

        def receive(message: PointStamped) -> None:
            stamp = message.header.stamp
            stamps.append((stamp.sec, stamp.nanosec))

        self._node.create_subscription(PointStamped, "shoe/cop", receive, qos.LIVE)
        self._until(lambda: len(stamps) >= LIVE_MESSAGES, SILENCE_S, lambda: "shoe/cop is not live")
        if any(later <= earlier for earlier, later in pairwise(stamps)):
            raise DemoError("the stamps of shoe/cop do not increase")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._undo.close()
        self._end_where_asked()

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._reported[status.name] = status.message

    def _spin(self) -> None:
        self._nodes.check()
        try:
            self._executor.spin_once(timeout_sec=0.05)
        finally:
            # Also in place of whatever error a second Ctrl-C, which comes at once, looks like.
            self._end_where_asked()

    def _end_where_asked(self) -> None:
        if self._asked.to_end:
            raise KeyboardInterrupt

    def _until(
        self, condition: Callable[[], bool], timeout_s: float, problem: Callable[[], str]
    ) -> None:
        deadline = time.monotonic() + timeout_s
        while not condition():
            self._spin()
            if time.monotonic() > deadline:
                raise DemoError(f"{problem()} within {timeout_s:g} s; see the nodes' logs")
