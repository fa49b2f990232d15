"""The inertial sensor at the root link."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.reality import ImuRules
from shoecal_core.simulation.snapshot import Snapshot


@dataclass(frozen=True)
class ImuReadings:
    """What the sensor measures, at one instant or many (...), in its own frame.

    Attributes:
        orientation: (..., 4) of its frame against a level one: x, y, z, w.
        angular_velocity: (..., 3) [rad/s].
        linear_acceleration: (..., 3) specific force: at rest the floor's push upwards [m/s^2].
    """

    orientation: FloatArray
    angular_velocity: FloatArray
    linear_acceleration: FloatArray


class Imu:
    """Turns the root link's true motion into readings.

    The sensor is mounted a little askew, which its readings alone cannot distinguish from a slope
    of the floor; its noise is white. Its yaw counts from the floor's x axis.
    """

    def __init__(
        self,
        rules: ImuRules,
        mounting: FloatArray,
        floor: FloatArray,
        noise: np.random.Generator,
    ) -> None:
        """A sensor.

        Args:
            rules: of its noise.
            mounting: (3,) rotation vector of its frame in the root link's [rad].
            floor: (3, 3) turns vectors of the floor's frame into a level one.
            noise: draws the noise.
        """
        self._rules, self._noise = rules, noise
        self._mounting = Rotation.from_rotvec(mounting)
        self._floor = Rotation.from_matrix(floor)

    def __call__(self, at: Snapshot) -> ImuReadings:
        """Read the root link's motion at one instant, or at many in their order."""
        rules, shape = self._rules, at.base_orientation.shape[:-1]
        white = self._noise.standard_normal((*shape, 9)).reshape(-1, 9)
        true = self._floor * Rotation.from_quat(at.base_orientation.reshape(-1, 4))
        orientation = (
            true * self._mounting * Rotation.from_rotvec(rules.orientation_std_rad * white[:, :3])
        )
        rate, force = (
            self._mounting.inv().apply(vectors.reshape(-1, 3))
            for vectors in (at.base_rate, at.base_force)
        )
        return ImuReadings(
            orientation.as_quat().reshape(*shape, 4),
            (rate + rules.gyro_std_rad_per_s * white[:, 3:6]).reshape(*shape, 3),
            (force + rules.accelerometer_std_mps2 * white[:, 6:]).reshape(*shape, 3),
        )


def base_motion(
    model: mujoco.MjModel, data: mujoco.MjData, base: int
) -> tuple[FloatArray, FloatArray]:
    """Rate of turn (3,) [rad/s] and specific force (3,) [m/s^2] of a body on a free joint.

    Both in its own frame, the force at its origin.
    """
    to_base = data.xmat[base].reshape(3, 3).T
    joint = model.body_dofadr[base]
    return to_base @ data.cvel[base, :3], to_base @ (
        data.qacc[joint : joint + 3] - model.opt.gravity
    )
