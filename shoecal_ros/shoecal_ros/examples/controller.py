"""How a controller reads `shoe/forces`: what it may use, and when it has to stop using it.

    ros2 run shoecal_ros example_controller --ros-args -p target_x:=0.02

It publishes on `example/cop_error` how far the CoP of both feet is off a place [m], and nothing at
all while that is not known. A balance controller would turn the error into ankle torques or a shift
of the CoM, and would hold its last posture where this one falls silent.
"""

from __future__ import annotations

import signal
import threading

import rclpy
import rclpy.time
from geometry_msgs.msg import Vector3Stamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from shoecal_msgs.msg import ShoeForces

OLDEST_S = 0.1
"""A sample older than this is of another posture."""
MOST_STD_M = 0.01
"""The calibration has to know the CoP better than this."""


class ExampleController(Node):
    """Reads forces, logs the error of the CoP."""

    def __init__(self) -> None:
        super().__init__("example_controller")
        self._target = (
            float(self.declare_parameter("target_x", 0.02).value),
            float(self.declare_parameter("target_y", 0.0).value),
        )
        self._error = self.create_publisher(Vector3Stamped, "example/cop_error", 10)
        # Only the newest sample counts; reliable, as it is sent.
        self.create_subscription(ShoeForces, "shoe/forces", self._control, QoSProfile(depth=1))

    def _control(self, forces: ShoeForces) -> None:
        stamp = rclpy.time.Time.from_msg(forces.header.stamp)
        age_s = (self.get_clock().now() - stamp).nanoseconds / 1e9
        both = forces.both
        # Not valid: a cell is broken, a foot stale, or there is no calibration.
        # No CoP: no foot is loaded. Extrapolating: beyond what the CoP correction was trained on.
        if not both.valid or not both.has_cop or both.extrapolating or age_s > OLDEST_S:
            return
        # NaN where the calibration has no covariance; then nothing is known against it.
        if max(both.cop_covariance[0], both.cop_covariance[3]) > MOST_STD_M**2:
            return
        error = Vector3Stamped(header=forces.header)
        error.vector.x = both.cop.x - self._target[0]
        error.vector.y = both.cop.y - self._target[1]
        self._error.publish(error)


def main() -> None:
    """Run it until Ctrl-C."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    # Not as an exception, which may come in the midst of taking a message.
    asked_to_end = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: asked_to_end.set())
    node = ExampleController()
    while not asked_to_end.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
