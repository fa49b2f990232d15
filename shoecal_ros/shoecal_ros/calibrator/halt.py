"""Stops a robot whose planner is gone: it was sent a whole motion, and nothing else watches it."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray
from rclpy.publisher import Publisher
from trajectory_msgs.msg import JointTrajectory

from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.health import Level
from shoecal_ros.common.hold import STOP_TIME_S, hold
from shoecal_ros.inputs.armed_input import ArmedInput
from shoecal_ros.inputs.joints import JointBatch

HEARD = 5
"""Messages of joint angles whose median is held: two of them may be false."""


class Halt:
    """Sends one command, when the node that armed the robot is gone, job or not.

    A planner that is there stops the robot itself, gently and knowing where it is to be.
    """

    def __init__(self, node: CalibratorBase, arming: ArmedInput) -> None:
        self._node = node
        self._arming = arming
        self._publisher: Publisher | None = None
        self._angles: deque[NDArray[np.float64]] = deque(maxlen=HEARD)
        self._sent = False
        self._run_id = ""

    def receive(self, batch: JointBatch) -> None:
        """Joint angles have come."""
        self._angles.extend(batch.angles)

    def watch(self) -> None:
        """Hold the robot if the node that armed it has just gone."""
        gone = self._arming.lapsed or self._arming.taken_over
        if not self._arming.reported and not gone:
            self._leave()
            return
        if self._publisher is None:
            # Already now: a robot has to know of a sender before it hears it.
            self._publisher = self._node.create_publisher(
                JointTrajectory, "joint_trajectory", qos.COMMAND
            )
        if not gone:
            self._sent, self._run_id = False, self._node.run_id
        elif self._angles and not self._sent:
            self._stop(self._publisher)

    def _stop(self, publisher: Publisher) -> None:
        angles = np.median(np.stack(self._angles), axis=0)
        # Back to where the robot was when it last reported it, no faster than it went on meanwhile.
        command = hold(self._node.robot, angles, STOP_TIME_S + self._node.joints.heard.age_s)
        publisher.publish(trajectory_to_ros(command))
        self._sent = True
        course = f" in the course of {self._run_id}" if self._run_id else ""
        self._node.log(Level.ERROR, f"the planner is gone{course}: commanded the robot to stop")

    def _leave(self) -> None:
        """Leave commands to the planner alone."""
        self._sent = False
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
