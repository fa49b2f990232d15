"""The robot's kinematics as CasADi expressions, written from the Pinocchio model.

One source serves the planner's derivatives and the estimator's batches; it agrees with
Pinocchio to rounding (see the tests).
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.robot import Robot


@dataclass(frozen=True)
class SymbolicPose:
    """A rotation (3, 3) and a translation (3, 1) of a frame in the base."""

    rotation: ca.SX
    translation: ca.SX

    def act(self, point: ca.SX | FloatArray) -> ca.SX:
        """A point (3,) of this frame [m] in the base frame, as (3, 1)."""
        return self.rotation @ ca.SX(point) + self.translation

    def inverse_act(self, point: ca.SX) -> ca.SX:
        """A point (3, 1) of the base frame [m] in this frame."""
        return self.rotation.T @ (point - self.translation)


class SymbolicKinematics:
    """Poses and CoM of a robot as expressions in its joint angles.

    Holding one means that its kinematics have been written out.

    Attributes:
        joint_angles: (m, 1) symbol of all joint angles [rad], or the expression given.
        joints: pose in the base of each joint of the model, by index.
        com: (3, 1) centre of mass in the base [m].
        soles: left, right sole frame in the base.
    """

    def __init__(self, robot: Robot, joint_angles: ca.SX | None = None) -> None:
        model = robot.model
        count = len(robot.joint_names)
        self.joint_angles = ca.SX.sym("q", count) if joint_angles is None else joint_angles
        identity = SymbolicPose(ca.SX.eye(3), ca.SX.zeros(3))
        self.joints: list[SymbolicPose] = [identity, identity]
        moment = ca.SX.zeros(3)
        for index in range(1, model.njoints):
            if index > 1:
                self.joints.append(self._joint(model, index, self.joint_angles[index - 2]))
            inertia = model.inertias[index]
            if inertia.mass > 0.0:
                moment += inertia.mass * self.joints[index].act(np.asarray(inertia.lever))
        self.com = moment / sum(inertia.mass for inertia in model.inertias)
        left, right = (
            self._attached(self.joints[foot.joint], foot.placement) for foot in robot.feet
        )
        self.soles = (left, right)

    def _joint(self, model: pin.Model, index: int, angle: ca.SX) -> SymbolicPose:
        placement = self._attached(self.joints[model.parents[index]], model.jointPlacements[index])
        linear, angular = joint_axis(model, index)
        if np.any(angular):
            cross = pin.skew(angular)
            turn = ca.SX.eye(3) + ca.sin(angle) * cross + (1.0 - ca.cos(angle)) * (cross @ cross)
            return SymbolicPose(placement.rotation @ turn, placement.translation)
        return SymbolicPose(placement.rotation, placement.act(linear * angle))

    @staticmethod
    def _attached(pose: SymbolicPose, placement: pin.SE3) -> SymbolicPose:
        return SymbolicPose(
            pose.rotation @ ca.SX(np.asarray(placement.rotation)),
            pose.act(np.asarray(placement.translation)),
        )


def joint_axis(model: pin.Model, index: int) -> tuple[FloatArray, FloatArray]:
    """Axis of a one-degree-of-freedom joint: (linear (3,), angular (3,)), one of them zero."""
    joint = model.joints[index]
    data = joint.createData()
    joint.calc(data, np.zeros(model.nq), np.zeros(model.nv))
    subspace = np.asarray(data.S).reshape(6)
    linear, angular = subspace[:3], subspace[3:]
    if np.any(linear) and np.any(angular):
        raise ShoecalError(
            f"joint '{model.names[index]}' is a screw; only revolute and prismatic ones are known"
        )
    return linear, angular


def evaluate(function: ca.Function, samples: FloatArray) -> FloatArray:
    """(T, m) values of a function of one vector (n,) -> (m,), of samples (T, n).

    Raises:
        ShapeError: for samples of another shape.
    """
    width = function.size1_in(0)
    if samples.ndim != 2 or samples.shape[1] != width:
        raise ShapeError("samples", f"(T, {width})", samples.shape)
    if not len(samples):
        return np.zeros((0, function.size1_out(0)))
    # CasADi takes one sample a column.
    return np.array(function(samples.T)).T
