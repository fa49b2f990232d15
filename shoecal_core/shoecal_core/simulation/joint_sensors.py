"""What a simulated robot reports of its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.encoders import Encoders
from shoecal_core.simulation.sampled_robot import SampledRobot
from shoecal_core.simulation.snapshot import Snapshot


@dataclass(frozen=True)
class JointReadings:
    """What the robot reports of its m joints.

    Attributes:
        angles: as encoders show them [rad].
        efforts: torque of each joint's motor [N m].
        temperatures: of each joint's motor [degC].
    """

    angles: FloatArray
    efforts: FloatArray
    temperatures: FloatArray


class JointSensors:
    """Encoders, torques and thermometers of the motors; joints of one motor share them."""

    def __init__(self, physics: RobotPhysics, drawn: SampledRobot) -> None:
        self._motor, self._ratio = physics.motor, physics.ratio
        self._encoders = Encoders(drawn.body)
        self._resolution = drawn.rules.joints.encoder_resolution_rad
        self._ambient = drawn.rules.servo.ambient_degc

    def __call__(self, at: Snapshot) -> JointReadings:
        """Read all joints at one instant or many."""
        angles = self._encoders.shown(self._ratio * at.motor_angle[..., self._motor])
        if self._resolution > 0.0:
            angles = np.rint(angles / self._resolution) * self._resolution
        return JointReadings(
            angles=angles,
            efforts=at.motor_torque[..., self._motor],
            temperatures=self._ambient + at.motor_heat[..., self._motor],
        )
