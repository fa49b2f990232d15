"""What the simulated robot tells of itself: joints, torso, motors."""

from __future__ import annotations

import math
import time

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import Imu, JointState, Temperature

from shoecal_core.model.robot import Robot
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import (
    BASE_LINK,
    SECOND_NS,
    JointSample,
    header_to_ros,
    joints_to_ros,
)
from shoecal_ros.simulator.simulated_body import Samples

PATIENCE_S = 5.0
"""Wall-clock time that the slowest listener may take."""
AGAIN_S = 1.0
"""Time between looks whether one that hangs takes something again."""
HEAT_NS = SECOND_NS
"""Simulated time between temperatures: motors warm up in minutes."""


class BodyPublishers:
    """Joint angles of every sample; orientation and temperatures of the last of some samples."""

    def __init__(self, node: Node, robot: Robot, *, waits: bool) -> None:
        """Publishers of a node.

        Args:
            node: of the simulator.
            robot: that is simulated.
            waits: for listeners that keep all; a real robot does not.
        """
        profile = qos.RAW if waits else qos.DEVICE
        self._names = robot.joint_names
        shared = {one.joint for one in robot.shared}
        self._motors = [index for index in range(len(self._names)) if index not in shared]
        self._joints = _Patient(node.create_publisher(JointState, "joint_states", profile))
        self._imu = _Patient(node.create_publisher(Imu, "imu", profile))
        self._temperatures = _Patient(
            node.create_publisher(Temperature, "joint_temperatures", profile)
        )
        self._heat_ns = 0

    def publish(self, samples: Samples) -> None:
        """Publish what has come of the simulation."""
        stamps = samples.stamp_ns.tolist()
        joints = samples.joints
        for stamp_ns, angles, efforts in zip(stamps, joints.angles, joints.efforts, strict=True):
            message = joints_to_ros(JointSample(stamp_ns, self._names, angles, efforts))
            self._joints.publish(message)
        self._imu.publish(_orientation(stamps[-1], samples.orientation[-1].tolist()))
        if stamps[-1] - self._heat_ns >= HEAT_NS:
            self._heat_ns = stamps[-1]
            for index in self._motors:
                header = header_to_ros(stamps[-1], self._names[index])
                degc = float(joints.temperatures[-1, index])
                self._temperatures.publish(Temperature(header=header, temperature=degc))


class _Patient:
    """A publisher that waits for the slowest of the listeners that keep all; none waits for ever.

    Who has taken nothing for PATIENCE_S hangs, and is only looked after now and then: time goes on
    without him, and a node that shall end does not stand with him.
    """

    def __init__(self, publisher: Publisher) -> None:
        self._publisher = publisher
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
            else:
                self._stuck_at = None
                return


def _orientation(stamp_ns: int, quaternion: list[float]) -> Imu:
    """Orientation alone; covariances of what a sensor does not tell begin with -1."""
    message = Imu(header=header_to_ros(stamp_ns, BASE_LINK))
    q = message.orientation
    q.x, q.y, q.z, q.w = quaternion
    message.angular_velocity_covariance[0] = -1.0
    message.linear_acceleration_covariance[0] = -1.0
    return message
