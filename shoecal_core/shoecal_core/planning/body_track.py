"""What a body does along a motion, by Pinocchio and numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import GRAVITY, Robot
from shoecal_core.planning.capsules import segment_distance

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BodyTrack:
    """T samples of a body, everything in the left sole's frame.

    Attributes:
        com: (T, 3) centre of mass [m].
        right_rotation: (T, 3, 3) turns vectors of the right sole's frame into the left's.
        right_translation: (T, 3) origin of the right sole [m].
        distances: (T, p) of the collision pairs [m].
        torques: (T, k) that the leg motors need to hold the posture [N m].
    """

    com: FloatArray
    right_rotation: FloatArray
    right_translation: FloatArray
    distances: FloatArray
    torques: FloatArray


def track(robot: Robot, positions: FloatArray) -> BodyTrack:
    """Follow all joint angles (T, m) [rad]."""
    model = robot.model
    data = model.createData()
    right_foot = robot.feet[1]
    coms, rotations, translations, torques = [], [], [], []
    ends = np.zeros((len(positions), len(robot.capsules), 2, 3))
    for index, angles in enumerate(positions):
        base = _standing(robot, data, angles)
        coms.append(pin.centerOfMass(model, data, base).copy())
        pin.updateFramePlacements(model, data)
        right = data.oMf[right_foot.frame]
        rotations.append(right.rotation.copy())
        translations.append(right.translation.copy())
        for capsule, end in zip(robot.capsules, ends[index], strict=True):
            pose = data.oMi[capsule.joint]
            end[:] = pose.act(capsule.start), pose.act(capsule.end)
        torques.append(_holding_torques(robot, data, base, coms[-1][:2], right))
    return BodyTrack(
        com=np.array(coms),
        right_rotation=np.array(rotations),
        right_translation=np.array(translations),
        distances=_distances(robot, ends),
        torques=np.array(torques),
    )


def _standing(robot: Robot, data: pin.Data, angles: FloatArray) -> FloatArray:
    """Configuration (7 + m,) whose base is placed so that the left sole is the world."""
    free = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], angles])
    pin.forwardKinematics(robot.model, data, free)
    foot = robot.feet[0]
    sole = data.oMi[foot.joint] * foot.placement
    standing: FloatArray = np.concatenate([pin.SE3ToXYZQUAT(sole.inverse()), angles])
    return standing


def _distances(robot: Robot, ends: FloatArray) -> FloatArray:
    pairs = np.array(robot.collision_pairs, dtype=int).reshape(-1, 2)
    radii = np.array([capsule.radius for capsule in robot.capsules])
    a, b = ends[:, pairs[:, 0]], ends[:, pairs[:, 1]]
    gaps = segment_distance(a[:, :, 0], a[:, :, 1], b[:, :, 0], b[:, :, 1])
    distances: FloatArray = gaps - radii[pairs].sum(axis=1) if len(pairs) else gaps
    return distances


def load_share(robot: Robot, support: DoubleSupport, cop: FloatArray) -> tuple[float, FloatArray]:
    """How a CoP (2,) in the left sole's frame [m] may come about.

    Returns:
        The left foot's share of the weight, and (2, 2) the CoP of the left and of the right
        foot, both in the left sole's frame: each as far from its sensing polygon's middle.
    """
    left, right = (foot.sensing_polygon.mean(axis=0) for foot in robot.feet)
    right = support.right_to_left(right)
    way = left - right
    share = float(np.clip((cop - right) @ way / (way @ way), 0.0, 1.0))
    aside = cop - (share * left + (1.0 - share) * right)
    return share, np.array([left + aside, right + aside])


def _holding_torques(
    robot: Robot, data: pin.Data, base: FloatArray, cop: FloatArray, right: pin.SE3
) -> FloatArray:
    """Motor torques (k,) of the legs under gravity, held by vertical forces at both feet."""
    support = DoubleSupport(
        float(right.translation[0]),
        float(right.translation[1]),
        float(np.arctan2(right.rotation[1, 0], right.rotation[0, 0])),
    )
    share, places = load_share(robot, support, cop)
    pin.computeJointJacobians(robot.model, data, base)
    torque = pin.computeGeneralizedGravity(robot.model, data, base)
    # Pinocchio's own gravity is rounded; forces and weights must balance.
    torque = torque * (GRAVITY / np.linalg.norm(robot.model.gravity.linear))
    for foot, part, place in zip(robot.feet, (share, 1.0 - share), places, strict=True):
        jacobian = pin.getJointJacobian(
            robot.model, data, foot.joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        force = np.array([0.0, 0.0, part * robot.mass * GRAVITY])
        arm = np.array([*place, 0.0]) - data.oMi[foot.joint].translation
        torque -= jacobian.T @ np.concatenate([force, np.cross(arm, force)])
    joints = torque[6:]
    for shared in robot.shared:
        joints[shared.leader] += shared.ratio * joints[shared.joint]
    motors: FloatArray = joints[robot.legs]
    return motors
