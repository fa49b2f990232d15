"""Where CoM and soles are in the robot's base, one sample at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from shoecal_core.model.robot import Robot

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BodyPose:
    """At one instant.

    Attributes:
        com: (3,) in the base [m].
        translation: (2, 3) origins of the left and the right sole frame in the base [m].
        quaternion: (2, 4) their orientations x, y, z, w.
        cop: (2,) modelled CoP in the left sole's frame [m]: the CoM's ground projection, the
            left sole taken as flat on a level floor.
    """

    com: FloatArray
    translation: FloatArray
    quaternion: FloatArray
    cop: FloatArray


class Body:
    """Forward kinematics of one robot."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._data = robot.model.createData()
        self._configuration = pin.neutral(robot.model)

    def pose(self, joint_angles: FloatArray) -> BodyPose:
        """At all joint angles (m,) [rad]."""
        model, data = self._robot.model, self._data
        # The free-flying base stands at the origin; each joint has one coordinate.
        self._configuration[7:] = joint_angles
        com = pin.centerOfMass(model, data, self._configuration, False)
        soles = [data.oMi[foot.joint] * foot.placement for foot in self._robot.feet]
        return BodyPose(
            com=np.array(com),
            translation=np.stack([sole.translation for sole in soles]),
            quaternion=np.stack([pin.Quaternion(sole.rotation).coeffs() for sole in soles]),
            cop=soles[0].actInv(com)[:2],
        )
