"""A controller that is sent trajectories by its topic."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_ros.adapters.controller import Controller, absent
from shoecal_ros.common import qos


class TopicController(Controller):
    """What it is sent ends at rest within half a second: nothing stops it sooner and as gently."""

    def __init__(self, node: Node, name: str) -> None:
        """Nothing is under way.

        Args:
            node: that speaks to it.
            name: of the controller.
        """
        self._publisher = node.create_publisher(
            JointTrajectoryMsg, f"{name}/joint_trajectory", qos.COMMAND
        )

    @property
    def missing(self) -> str:
        """Why the topic has no subscriber; empty where it has one."""
        heard = self._publisher.get_subscription_count() > 0
        return "" if heard else absent(self._publisher.topic_name)

    def send(self, message: JointTrajectoryMsg) -> None:
        """Publish it."""
        self._publisher.publish(message)

    def stop(self) -> None:
        """Nothing more is sent."""

    def watch(self) -> None:
        """Nothing is left to be done."""

    @property
    def busy(self) -> bool:
        """Whether something that was sent has not come there."""
        return not self._publisher.wait_for_all_acked(Duration())
