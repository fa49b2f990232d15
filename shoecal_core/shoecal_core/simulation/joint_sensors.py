"""What a simulated robot reports of its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.compiled_robot import RobotPhysics
from shoecal_core.simulation.sampled_parts import SampledBody
from shoecal_core.simulation.sampled_robot import SampledRobot
from shoecal_core.simulation.snapshot import Snapshot

_ITERATIONS = 6
"""Of a fixed point whose error shrinks by the amplitude [rad] each time."""


class Encoders:
    """Encoders with a wrong zero, and with an error that comes once a turn.

    A magnet that sits off its axis by a part of its distance makes an encoder show

        shown(q) = q + zero + A (sin(q + phase) - sin(phase))

    of a motor's angle q, so that `zero` is the error where q is 0. Joints of one motor share its
    encoder: theirs show ratio times as much.
    """

    def __init__(self, body: SampledBody) -> None:
        self._zero = body.encoder_error
        leader, self._ratio = np.arange(len(body.joints)), np.ones(len(body.joints))
        for shared in body.robot.shared:
            leader[shared.joint], self._ratio[shared.joint] = shared.leader, shared.ratio
        self._amplitude, self._phase = body.eccentricity[leader].T

    def shown(self, angles: FloatArray) -> FloatArray:
        """(..., m) [rad] of the joints' motor angles (..., m) [rad]."""
        return angles + self._error(angles)

    def angles(self, shown: FloatArray) -> FloatArray:
        """(..., m) motor angles [rad] at which encoders show (..., m) [rad]."""
        found = shown - self._zero
        for _ in range(_ITERATIONS if self._amplitude.any() else 0):
            found = shown - self._error(found)
        return found

    def _error(self, angles: FloatArray) -> FloatArray:
        turned = angles / self._ratio + self._phase
        wave = self._ratio * self._amplitude * (np.sin(turned) - np.sin(self._phase))
        error: FloatArray = self._zero + wave
        return error


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
