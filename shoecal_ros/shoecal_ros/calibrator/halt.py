"""Stops a robot whose planner is gone: it was sent a whole motion, and nobody else watches it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.publisher import Publisher
from trajectory_msgs.msg import JointTrajectory

from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.hold import hold

if TYPE_CHECKING:
    from shoecal_ros.nodes.calibrator import Calibrator

STOP_TIME_S = 0.5


class Halt:
    """Sends one command, at the moment at which arming lapses in the course of a job.

    A planner that is there stops the robot itself, gently and knowing where it is to be.
    """

    def __init__(self, node: Calibrator) -> None:
        self._node = node
        self._publisher: Publisher | None = None
        self._lapsed = False

    def begin(self) -> None:
        """A job begins: be ready, for a robot has to know of a sender before it hears it."""
        if self._publisher is None:
            self._publisher = self._node.create_publisher(
                JointTrajectory, "joint_trajectory", qos.COMMAND
            )

    def end(self) -> None:
        """The job is over: leave commands to the planner alone."""
        if self._publisher is not None and not self._lapsed:
            self._node.destroy_publisher(self._publisher)
            self._publisher = None

    def watch(self, *, lapsed: bool) -> None:
        """Hold the robot where arming has just lapsed.

        Args:
            lapsed: whether who armed the robot has fallen silent.
        """
        latest = self._node.joints.latest
        if lapsed and not self._lapsed and self._publisher is not None and latest is not None:
            command = hold(self._node.robot, latest.angles[0], STOP_TIME_S)
            self._publisher.publish(trajectory_to_ros(command))
            self._node.get_logger().error("the planner is gone: told the robot to stop")
        self._lapsed = lapsed
