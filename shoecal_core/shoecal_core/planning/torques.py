"""Motor torques that hold a posture, as expressions.

Forces are vertical. How two feet share a weight is not determined by statics; here each foot's
CoP lies equally far aside from its sensing polygon's middle, and the shares follow. A robot on
one foot has all its weight there.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from shoecal_core.model.robot import GRAVITY, Robot
from shoecal_core.model.symbolic import SymbolicKinematics, joint_axis


def foot_forces(
    robot: Robot, foot_pose: ca.SX, share: ca.SX, cop: ca.SX
) -> list[tuple[ca.SX, ca.SX]]:
    """Share of the weight and place (3, 1) in the left sole's frame [m] of either foot's force.

    Args:
        robot: whose feet.
        foot_pose: (12, 1) as FootPose.parameters.
        share: (2, 1) least and greatest share of the left foot.
        cop: (2, 1) of both feet together, left sole's frame [m].
    """
    left, right = (foot.sensing_polygon.mean(axis=0) for foot in robot.feet)
    rotation, translation = ca.reshape(foot_pose[:9], 3, 3), foot_pose[9:]
    middle_left = ca.SX(left)
    middle_right = rotation[:2, :2] @ right + translation[:2]
    way = middle_left - middle_right
    even = ca.dot(cop - middle_right, way) / ca.sumsqr(way)
    on_left = ca.fmin(ca.fmax(even, share[0]), share[1])
    aside = cop - (on_left * middle_left + (1.0 - on_left) * middle_right)
    return [
        (part, ca.vertcat(middle + aside, 0.0))
        for part, middle in ((on_left, middle_left), (1.0 - on_left, middle_right))
    ]


def holding_torques(
    robot: Robot, body: SymbolicKinematics, foot_pose: ca.SX, share: ca.SX, cop: ca.SX
) -> ca.SX:
    """(k, 1) torques of the leg motors [N m], both soles level.

    A motor holds what acts on its far side: the floor's force on the foot and the weight of
    all links between. Arguments as those of `foot_forces`.
    """
    model = robot.model
    up = body.soles[0].rotation[:, 2]
    torques = [ca.SX(0) for _ in robot.joint_names]
    forces = foot_forces(robot, foot_pose, share, cop)
    for foot, (part, place) in zip(robot.feet, forces, strict=True):
        at, load = body.soles[0].act(place), part * robot.weight
        for index in list(model.supports[foot.joint])[2:]:
            pose = body.joints[index]
            moment = load * ca.cross(at - pose.translation, up)
            force = load
            for link in model.subtrees[index]:
                inertia = model.inertias[link]
                weight = inertia.mass * GRAVITY
                lever = body.joints[link].act(np.asarray(inertia.lever)) - pose.translation
                moment -= weight * ca.cross(lever, up)
                force -= weight
            linear, angular = joint_axis(model, index)
            torques[index - 2] -= ca.dot(pose.rotation @ angular, moment)
            torques[index - 2] -= ca.dot(pose.rotation @ linear, up) * force
    for shared in robot.shared:
        torques[shared.leader] += shared.ratio * torques[shared.joint]
    motors: ca.SX = ca.vertcat(*(torques[index] for index in robot.legs))
    return motors
