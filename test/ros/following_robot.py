"""A robot that does what trajectories say, and tells all that is watched meanwhile."""

from __future__ import annotations

import numpy as np
from sensor_msgs.msg import Imu, Temperature
from shoecal_msgs.msg import FootState, ShoeState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import nao
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.shoe.shoe import FEET
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import header_to_ros, time_from_ros, trajectory_from_ros


class FollowingRobot(StandingRobot):
    """Follows at once and exactly.

    Attributes:
        leaning: by which its torso pitches beyond what its joints say [rad].
        loaded: which feet its shoes say carry.
        degc: temperature of its right knee's motor [degC].
        offset: by which its left knee stays off what it is told, until told to hold [rad].
    """

    def __init__(self, world: World, support: DoubleSupport) -> None:
        super().__init__(world, support)
        self._body = Kinematics(nao())
        self._start = self.angles
        self._command: JointTrajectoryMsg | None = None
        self._begun_ns = 0
        node = world.node
        # As sensors of many robots are published: not reliably.
        self._imu = node.create_publisher(Imu, "imu", qos.EITHER)
        self._states = node.create_publisher(ShoeState, "shoe/state", qos.LATCHED)
        self._heat = node.create_publisher(Temperature, "joint_temperatures", qos.RAW)
        node.create_subscription(JointTrajectoryMsg, "joint_trajectory", self._follow, qos.COMMAND)
        self.recover()

    def recover(self) -> None:
        """Stand as at the begin, everything well."""
        self.pace = 4
        self.leaning = self.offset = 0.0
        self.loaded = [True, True]
        self.degc = 40.0
        self.publishes_joints = self.publishes_voltages = True
        self._command = None
        self.step_to(self.support)

    @property
    def lifted(self) -> float:
        """Height of the right sole over the left one [m]."""
        return float(self._body.states(self.angles[None]).translation[0, 2])

    @property
    def still(self) -> bool:
        """Whether it has come to the end of what it was told."""
        if self._command is None:
            return True
        duration_s = float(trajectory_from_ros(self._command).times[-1])
        return self.stamp_ns - self._begun_ns > 1e9 * duration_s

    def _follow(self, message: JointTrajectoryMsg) -> None:
        self._command = message
        self._begun_ns = time_from_ros(message.header.stamp) or self.stamp_ns
        self._start = self.angles.copy()
        if len(message.points) == 1:
            self.offset = 0.0

    def _tell(self) -> None:
        if self._command is not None:
            trajectory = trajectory_from_ros(self._command).full(nao(), self._start)
            self.angles = trajectory.at(np.array((self.stamp_ns - self._begun_ns) / 1e9)).copy()
            self.angles[nao().joint("LKneePitch")] += self.offset
        super()._tell()
        self._imu.publish(self._inertia())
        feet = [
            FootState(foot=foot, loaded=loaded, valid=True)
            for foot, loaded in zip(FEET, self.loaded, strict=True)
        ]
        self._states.publish(ShoeState(state=ShoeState.CALIBRATED, feet=feet))
        header = header_to_ros(self.stamp_ns, "RKneePitch")
        self._heat.publish(Temperature(header=header, temperature=self.degc))

    def _inertia(self) -> Imu:
        """An accelerometer alone."""
        message = Imu(header=header_to_ros(self.stamp_ns, "base_link"))
        message.orientation_covariance[0] = -1.0
        up = self._body.states(self.angles[None]).left_rotation[0][:, 2]
        sine, cosine = np.sin(self.leaning), np.cos(self.leaning)
        felt = message.linear_acceleration
        felt.x = 9.81 * float(cosine * up[0] + sine * up[2])
        felt.y = 9.81 * float(up[1])
        felt.z = 9.81 * float(cosine * up[2] - sine * up[0])
        return message
