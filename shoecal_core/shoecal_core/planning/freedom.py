"""Which ways the CoP can go while both soles stay where they are, flat on the floor."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.urdf import ROOT_JOINTS

WAYS = ("forward", "sideways")
_HELD = 1e-6
"""Singular values below it, over the largest, are zero: what both soles allow."""
_LEAST = 0.2
"""Of `cop_freedom`: with ankles that turn both ways it is 0.3 or more; what turning the pelvis does
without them, 0.1."""
_ABOUT = 0.5
"""Cosine: an axis nearer to a sole's turns the foot about that."""


def cop_freedom(robot: Robot) -> FloatArray:
    """(2,) by how much the CoP moves forward and sideways at most, in the robot's posture.

    Over the height of the CoM, by the norm of what moves: the legs' motors [rad] and the base
    [m, rad].
    """
    model, data = robot.model, robot.model.createData()
    q = np.concatenate((pin.neutral(model)[:7], robot.posture))
    pin.computeJointJacobians(model, data, q)
    com = np.array(pin.jacobianCenterOfMass(model, data, q))
    moves = _moves(robot)
    held = np.vstack([pin.getJointJacobian(model, data, foot.joint, pin.LOCAL) @ moves
                      for foot in robot.feet])  # fmt: skip
    _, values, rows = np.linalg.svd(held)
    free = moves @ rows[int(np.sum(values > _HELD * values[0])) :].T
    left = data.oMi[robot.feet[0].joint] * robot.feet[0].placement
    height = float((data.com[0] - left.translation) @ left.rotation[:, 2])
    found: FloatArray = np.linalg.norm(left.rotation[:, :2].T @ com @ free, axis=1) / height
    return found


def held_way(robot: Robot) -> str:
    """The way, of `WAYS`, in which the CoP cannot be moved, and why; empty where it can in both."""
    for way, freedom in zip(WAYS, cop_freedom(robot), strict=True):
        if freedom < _LEAST:
            return f"{way}{missing_ankle(robot)}"
    return ""


def missing_ankle(robot: Robot) -> str:
    """In parentheses, that the feet have no ankle roll; empty where they have one."""
    return "" if _turns_below_knee(robot, 0) else " (the feet have no ankle roll)"


def _moves(robot: Robot) -> FloatArray:
    """(nv, 6 + k) velocities of the model by those of the base and of the legs' motors."""
    moves = np.zeros((robot.model.nv, 6 + len(robot.legs)))
    moves[:6, :6] = np.eye(6)
    moves[6 + robot.legs, 6 + np.arange(len(robot.legs))] = 1.0
    for shared in robot.shared:
        moves[6 + shared.joint] = shared.ratio * moves[6 + shared.leader]
    return moves


def _turns_below_knee(robot: Robot, axis: int) -> bool:
    """Whether in each leg one of the last two joints turns about an axis (0 x, 1 y) of the sole."""
    data = robot.model.createData()
    q = np.concatenate((pin.neutral(robot.model)[:7], robot.posture))
    pin.computeJointJacobians(robot.model, data, q)
    moved = {int(index) + ROOT_JOINTS for index in robot.moved}
    found = []
    for foot in robot.feet:
        last = [joint for joint in robot.model.supports[foot.joint] if joint in moved][-2:]
        sole = (data.oMi[foot.joint] * foot.placement).rotation[:, axis]
        turns = [pin.getJointJacobian(robot.model, data, joint, pin.WORLD)[3:, joint + 4]
                 for joint in last]  # fmt: skip
        found.append(any(abs(float(sole @ turn)) > _ABOUT for turn in turns))
    return all(found)
