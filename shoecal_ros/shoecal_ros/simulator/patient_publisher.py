"""A publisher that runs ahead of real time, and waits for subscribers that want every message."""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.graph_monitor import node_name

PATIENCE_S = 5.0
"""Wall-clock time that the slowest listener may take."""
AGAIN_S = 1.0
"""Time between looks whether one that hangs takes something again."""


class PatientPublisher:
    """Waits for the slowest of the listeners that keep all; none is waited for for ever.

    Who has taken nothing for PATIENCE_S hangs, and is only looked after now and then: time goes on
    without him, and a node that shall end does not stand with him.

    Attributes:
        problem: who may hang, and the cure; None while everybody takes what comes.
    """

    def __init__(self, node: Node, kind: type[Any], topic: str, profile: QoSProfile) -> None:
        self.problem: Problem | None = None
        self._node = node
        self._publisher = node.create_publisher(kind, topic, profile)
        self._stuck_at: float | None = None
        self._not_before = -math.inf

    def publish(self, message: object) -> None:
        """Publish; what finds no room in time is lost."""
        while (now := time.monotonic()) >= self._not_before:
            try:
                self._publisher.publish(message)
            except rclpy_implementation.RCLError:
                # The middleware itself has waited a little.
                self._stuck_at = self._stuck_at or now
                if now - self._stuck_at > PATIENCE_S:
                    self._not_before = now + AGAIN_S
                    self.problem = self._hanging()
            else:
                self._stuck_at = self.problem = None
                return

    def _hanging(self) -> Problem:
        """Names all who may be waited for: of a history not every middleware reports."""
        topic = self._publisher.topic_name
        names = sorted(
            f"'{node_name(info)}'"
            for info in self._node.get_subscriptions_info_by_topic(topic)
            if info.qos_profile.reliability is not ReliabilityPolicy.BEST_EFFORT
            if info.qos_profile.history is not HistoryPolicy.KEEP_LAST
        )
        whom = f"one of {', '.join(names)}" if len(names) > 1 else "".join(names) or "somebody"
        return Problem(
            Code.LISTENER_HANGS,
            f"{whom} subscribes to {topic} and takes nothing, so it is published no more; end the "
            "node that hangs, let it keep the last messages instead of all, or simulate at a speed "
            "of 1",
        )
