"""A robot that stands: its joint angles, at the rate of a NAO.

python robot.py
"""

from __future__ import annotations

from rclpy.node import Node
from sensor_msgs.msg import JointState

from live.bodies import robot, standing
from live.spinning import spin
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import JointSample, joints_to_ros

RATE = 83.0
"""Of a NAO's joint angles [Hz]."""


class StandingRobot(Node):
    """Publishes."""

    def __init__(self) -> None:
        super().__init__("standing_robot")
        self._publisher = self.create_publisher(JointState, "joint_states", qos.RAW)
        self._angles = standing()
        self.create_timer(1.0 / RATE, self._tell)

    def _tell(self) -> None:
        now_ns = self.get_clock().now().nanoseconds
        self._publisher.publish(
            joints_to_ros(JointSample(now_ns, robot().joint_names, self._angles))
        )


if __name__ == "__main__":
    spin(StandingRobot)
