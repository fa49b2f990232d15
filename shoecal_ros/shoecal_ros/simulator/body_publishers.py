"""What the simulated robot publishes of itself: joints, torso, motors."""

from __future__ import annotations

from rclpy.node import Node
from sensor_msgs.msg import Imu, JointState, Temperature

from shoecal_core.robot.robot import Robot
from shoecal_core.simulation.reality import PlantVariation
from shoecal_ros.common import qos
from shoecal_ros.common.codes import joined
from shoecal_ros.common.conversions import (
    BASE_LINK,
    SECOND_NS,
    JointSample,
    header_to_ros,
    joints_to_ros,
)
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.simulator.patient_publisher import PatientPublisher
from shoecal_ros.simulator.simulated_body import BodySamples

HEAT_NS = SECOND_NS
"""Simulated time between temperatures: motors warm up in minutes."""


class BodyPublishers:
    """Joint angles of every sample; orientation and temperatures of the last of some samples.

    Orientation and temperatures where the robot's reality has their sensors.
    """

    def __init__(self, node: Node, robot: Robot, reality: PlantVariation, *, waits: bool) -> None:
        """Publishers of a node.

        Args:
            node: of the simulator.
            robot: that is simulated.
            reality: says which sensors it has.
            waits: for listeners that keep all; a real robot does not.
        """
        profile = qos.RAW if waits else qos.DEVICE
        self._names = robot.joint_names
        # A joint that follows another one has no motor.
        silent = {one.joint for one in robot.shared}
        if not reality.servo.temperatures_told:
            silent.update(range(len(self._names)))
        self._motors = [index for index in range(len(self._names)) if index not in silent]
        self._joints = PatientPublisher(node, JointState, "joint_states", profile)
        self._imu = PatientPublisher(node, Imu, "imu", profile) if reality.imu.present else None
        self._temperatures = PatientPublisher(node, Temperature, "joint_temperatures", profile)
        self._heat_ns = 0

    @property
    def condition(self) -> Condition:
        """For diagnostics: whether somebody hangs for whom the others wait."""
        all_of_them = (self._joints, self._imu, self._temperatures)
        problem = joined(one.problem for one in all_of_them if one and one.problem is not None)
        if problem is None:
            return Condition(Level.OK, "no subscriber hangs")
        return Condition(Level.WARN, problem.message, code=problem.code)

    def publish(self, samples: BodySamples) -> None:
        """Publish what has come of the simulation."""
        stamps = samples.stamp_ns.tolist()
        joints = samples.joints
        for stamp_ns, angles, efforts in zip(stamps, joints.angles, joints.efforts, strict=True):
            message = joints_to_ros(JointSample(stamp_ns, self._names, angles, efforts))
            self._joints.publish(message)
        if self._imu is not None:
            self._imu.publish(_orientation(stamps[-1], samples.orientation[-1].tolist()))
        if stamps[-1] - self._heat_ns >= HEAT_NS:
            self._heat_ns = stamps[-1]
            for index in self._motors:
                header = header_to_ros(stamps[-1], self._names[index])
                degc = float(joints.temperatures[-1, index])
                self._temperatures.publish(Temperature(header=header, temperature=degc))


def _orientation(stamp_ns: int, quaternion: list[float]) -> Imu:
    """Orientation alone; covariances of what a sensor does not give begin with -1."""
    message = Imu(header=header_to_ros(stamp_ns, BASE_LINK))
    q = message.orientation
    q.x, q.y, q.z, q.w = quaternion
    message.angular_velocity_covariance[0] = -1.0
    message.linear_acceleration_covariance[0] = -1.0
    return message
