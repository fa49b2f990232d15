"""A controller that is sent trajectories by its topic."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from rclpy.duration import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_ros.adapters.controller import FOUND_S, Controller, absent
from shoecal_ros.common import qos

LATE_S = 1.0
"""For so long after its time a motion may go on: a topic does not report when it has ended."""


class TopicController(Controller):
    """It is stopped by a trajectory, too."""

    def __init__(
        self,
        node: Node,
        name: str,
        held: Callable[[], JointTrajectoryMsg | None],
    ) -> None:
        """Nothing is under way.

        Args:
            node: that speaks to it.
            name: of the controller.
            held: a command to hold the joints where they are; none where that is not known.
        """
        self._publisher = node.create_publisher(
            JointTrajectoryMsg, f"{name}/joint_trajectory", qos.COMMAND
        )
        self._held = held
        self._until_s = -math.inf
        self._hold_until_s = -math.inf

    @property
    def missing(self) -> str:
        """Why the topic has no subscriber; empty where it has one."""
        heard = self._publisher.get_subscription_count() > 0
        return "" if heard else absent(self._publisher.topic_name)

    def send(self, message: JointTrajectoryMsg, duration_s: float) -> None:
        """Publish it."""
        self._publisher.publish(message)
        self._until_s = time.monotonic() + duration_s + LATE_S
        self._hold_until_s = -math.inf

    def stop(self) -> None:
        """Hold, where it may be on its way."""
        if time.monotonic() < self._until_s:
            self._until_s = -math.inf
            self._hold_until_s = time.monotonic() + FOUND_S
            self.watch()

    def watch(self) -> None:
        """Hold where that could not be before."""
        if time.monotonic() < self._hold_until_s and not self.missing and self._hold():
            self._hold_until_s = -math.inf

    @property
    def busy(self) -> bool:
        """Whether something that was sent has not come there."""
        return not self._publisher.wait_for_all_acked(Duration())

    def _hold(self) -> bool:
        """Whether it could be sent."""
        command = self._held()
        if command is not None:
            self._publisher.publish(command)
        return command is not None
