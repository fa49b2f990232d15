"""Motions of a stand-in robot, and what is seen of them."""

from __future__ import annotations

import numpy as np
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState

from ros.adapters.conftest import Adapted
from ros.bodies import nao
from ros.world import Received
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos

KNEE = "LKneePitch"
WAY = 0.1


def squat(duration: float, way: float = WAY, begin: float = 0.0) -> JointTrajectory:
    """Knees bend on, from where they are bent to; every joint of the legs is told."""
    robot = nao()
    names = tuple(robot.joint_names[joint] for joint in robot.moved)
    times = np.linspace(0.0, duration, 1 + round(duration / 0.05))
    positions = np.tile(robot.posture[robot.moved], (len(times), 1))
    positions[:, names.index(KNEE)] += begin + way * np.linspace(0.0, 1.0, len(times))
    return JointTrajectory(names, times, positions)


class Knee:
    """What the robot tells of its left knee, against where it stood at the beginning [rad]."""

    def __init__(self, robot: Adapted) -> None:
        self._robot = robot
        self._heard: Received = robot.world.receive(JointState, "joint_states", qos.LIVE)
        robot.world.until(lambda: len(self._heard) > 5)
        self.first = self._now()

    @property
    def way(self) -> float:
        return self._now() - self.first

    @property
    def count(self) -> int:
        return len(self._heard)

    @property
    def stamp(self) -> Time:
        """Of the newest joint angles."""
        return self._heard.last.header.stamp

    def rests(self) -> bool:
        """Whether nothing moves for half a second."""
        where, count = self.way, self.count
        self._robot.world.until(lambda: self.count > count + 25)
        return abs(self.way - where) < 1e-9

    def _now(self) -> float:
        message = self._heard.last
        return float(message.position[message.name.index(KNEE)])


def bent(way: float) -> FloatArray:
    """(m,) joint angles with the knee so much farther bent than at the beginning [rad]."""
    angles = nao().posture.copy()
    angles[nao().joint(KNEE)] += way
    return angles
