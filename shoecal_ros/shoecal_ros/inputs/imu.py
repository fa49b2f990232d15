"""Which way is up, by an inertial sensor on the torso."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.inputs.arrival_monitor import ArrivalMonitor

SMOOTHING_S = 0.2
"""Time constant that takes shaking out of an accelerometer's direction."""
_ROOT = 1
"""Joint of the model that the torso hangs on."""


class ImuInput:
    """The newest upward direction.

    Attributes:
        up: (3,) in the base's frame; None before there was one.
        heard: when something usable last came.
    """

    def __init__(self, robot: Robot, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing heard.

        Args:
            robot: whose torso it sits on.
            clock: monotonic [s].
        """
        self.up: FloatArray | None = None
        self._robot = robot
        self.heard = ArrivalMonitor(clock)
        self._stamp_ns = 0

    def take(self, messages: Sequence[Any]) -> None:
        """Take sensor_msgs/Imu messages in order; those without a direction do not count."""
        for message in messages:
            up = _from_orientation(message)
            if up is not None:
                self.up = self._in_base(message.header.frame_id) @ up
            else:
                up = _from_acceleration(message)
                if up is None:
                    continue
                self._blend(self._in_base(message.header.frame_id) @ up, message)
            self._stamp_ns = time_from_ros(message.header.stamp)
            self.heard.note()

    def _blend(self, up: FloatArray, message: Any) -> None:
        since = (time_from_ros(message.header.stamp) - self._stamp_ns) / 1e9
        if self.up is None or since < 0.0:
            self.up = up
            return
        blended = self.up + (up - self.up) * (1.0 - np.exp(-since / SMOOTHING_S))
        self.up = blended / np.linalg.norm(blended)

    def _in_base(self, frame: str) -> FloatArray:
        """(3, 3) from a frame's axes to the base's; the same where the URDF does not know it."""
        model = self._robot.model
        if not model.existFrame(frame):
            frame = frame.rpartition("/")[2]  # behind a prefix
        if frame and model.existFrame(frame):
            known = model.frames[model.getFrameId(frame)]
            if known.parentJoint == _ROOT:
                return np.array(known.placement.rotation)
        return np.eye(3)


def _from_orientation(message: Any) -> FloatArray | None:
    """(3,) where the sensor gives an orientation (REP-145: else its covariance begins with -1)."""
    q = message.orientation
    quaternion = np.array([q.x, q.y, q.z, q.w])
    length = float(np.linalg.norm(quaternion))
    if message.orientation_covariance[0] < 0.0 or not 0.5 < length < 2.0:
        return None
    x, y, z, w = quaternion / length
    # The world's upward axis in the sensor's frame: the rotation's third row.
    return np.array([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)])


def _from_acceleration(message: Any) -> FloatArray | None:
    """(3,) at rest an accelerometer feels the floor push upwards."""
    a = message.linear_acceleration
    felt = np.array([a.x, a.y, a.z])
    size = float(np.linalg.norm(felt))
    if message.linear_acceleration_covariance[0] < 0.0 or not 0.5 < size / GRAVITY < 2.0:
        return None
    return felt / size
