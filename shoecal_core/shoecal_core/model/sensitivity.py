"""How the modelled CoP and the feet's relative pose answer to small errors of the robot's model.

Errors are those of its table and its encoders: masses and centres of mass of the links (as the
Pinocchio model lumps them, one a joint) and joint angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.model.robot import Robot
from shoecal_core.model.symbolic import SymbolicKinematics

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BodySensitivity:
    """Derivatives at T samples, in the frame of one sole; L links, m joints.

    Attributes:
        links: names of the joints that carry the L links with a mass.
        cop_by_mass: (T, 2, L) of the CoP to each link's relative mass [m].
        cop_by_com: (T, 2, L, 3) to each link's centre of mass, in its own frame [1].
        cop_by_joint: (T, 2, m) to joint angles [m/rad].
        support_by_joint: (T, 3, m) of dx, dy, dtheta of the right sole in the left sole's frame
            [m/rad, m/rad, 1].
    """

    links: tuple[str, ...]
    cop_by_mass: FloatArray
    cop_by_com: FloatArray
    cop_by_joint: FloatArray
    support_by_joint: FloatArray


class SensitiveBody:
    """Compiled derivatives of one robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        inertias = robot.model.inertias
        self._carriers = [i for i in range(1, robot.model.njoints) if inertias[i].mass > 0.0]
        self.links = tuple(str(robot.model.names[index]) for index in self._carriers)
        self._functions: dict[int, ca.Function] = {}

    def _function(self, foot: int) -> ca.Function:
        """All derivatives as one vector, those of the CoP in the frame of a sole."""
        if foot not in self._functions:
            self._functions[foot] = self._derivatives(foot)
        return self._functions[foot]

    def _derivatives(self, foot: int) -> ca.Function:
        body = SymbolicKinematics(self.robot)
        left, right = body.soles
        sole = body.soles[foot]
        inertias = self.robot.model.inertias
        total = sum(inertia.mass for inertia in inertias)
        by_mass, by_com = [], []
        for index in self._carriers:
            share = inertias[index].mass / total
            pose = body.joints[index]
            way = pose.act(np.asarray(inertias[index].lever)) - body.com
            by_mass.append(share * (sole.rotation.T @ way)[:2])
            by_com.append(share * (sole.rotation.T @ pose.rotation)[:2, :])
        cop = sole.inverse_act(body.com)[:2]
        turn = left.rotation.T @ right.rotation
        support = ca.vertcat(
            left.inverse_act(right.translation)[:2], ca.atan2(turn[1, 0], turn[0, 0])
        )
        outputs = ca.vertcat(
            ca.vec(ca.horzcat(*by_mass)),
            ca.vec(ca.horzcat(*by_com)),
            ca.vec(ca.jacobian(cop, body.joint_angles)),
            ca.vec(ca.jacobian(support, body.joint_angles)),
        )
        return ca.Function("sensitivity", [body.joint_angles], [outputs], {"cse": True})

    def at(self, joint_angles: FloatArray, foot: int = 0) -> BodySensitivity:
        """Evaluate T samples of all joint angles (T, m) [rad].

        Args:
            foot: index of the sole in whose frame the CoP is told.
        """
        count, joints = len(joint_angles), len(self.robot.joint_names)
        if joint_angles.ndim != 2 or joint_angles.shape[1] != joints:
            raise ShapeError("joint angles", f"(T, {joints})", joint_angles.shape)
        values = np.array(self._function(foot)(joint_angles.T)).T
        links = len(self.links)
        sizes = np.cumsum([2 * links, 6 * links, 2 * joints])
        mass, com, joint, support = np.split(values, sizes, axis=1)
        # CasADi stores matrices by columns: the last index runs slowest.
        return BodySensitivity(
            links=self.links,
            cop_by_mass=mass.reshape(count, links, 2).transpose(0, 2, 1),
            cop_by_com=com.reshape(count, links, 3, 2).transpose(0, 3, 1, 2),
            cop_by_joint=joint.reshape(count, joints, 2).transpose(0, 2, 1),
            support_by_joint=support.reshape(count, joints, 3).transpose(0, 2, 1),
        )
