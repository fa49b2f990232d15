"""What a body does along a motion, by Pinocchio and numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

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


def track(
    robot: Robot, positions: FloatArray, shares: FloatArray | tuple[float, float] = (0.0, 1.0)
) -> BodyTrack:
    """Follow all joint angles (T, m) [rad].

    Args:
        robot: whose body.
        positions: where its joints are.
        shares: (T, 2) or (2,) least and greatest share of the weight on the left foot.
    """
    model, count = robot.model, len(positions)
    data = model.createData()
    coms = np.zeros((count, 3))
    rotations, translations = np.zeros((count, 3, 3)), np.zeros((count, 3))
    ends = np.zeros((count, len(robot.capsules), 2, 3))
    gravity, jacobians = np.zeros((count, model.nv)), np.zeros((count, 2, 6, model.nv))
    ankles = np.zeros((count, 2, 3))
    for index, angles in enumerate(positions):
        base = _standing(robot, data, angles)
        coms[index] = pin.centerOfMass(model, data, base)
        pin.updateFramePlacements(model, data)
        right = data.oMf[robot.feet[1].frame]
        rotations[index], translations[index] = right.rotation, right.translation
        for capsule, end in zip(robot.capsules, ends[index], strict=True):
            pose = data.oMi[capsule.joint]
            end[:] = pose.act(capsule.start), pose.act(capsule.end)
        gravity[index] = pin.computeGeneralizedGravity(model, data, base)
        pin.computeJointJacobians(model, data, base)
        for side, foot in enumerate(robot.feet):
            jacobians[index, side] = pin.getJointJacobian(
                model, data, foot.joint, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            ankles[index, side] = data.oMi[foot.joint].translation
    share, places = load_share(robot, rotations, translations, coms[:, :2], shares)
    return BodyTrack(
        com=coms,
        right_rotation=rotations,
        right_translation=translations,
        distances=_distances(robot, ends),
        torques=_holding_torques(robot, gravity, jacobians, ankles, share, places),
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


def load_share(
    robot: Robot,
    right_rotation: FloatArray,
    right_translation: FloatArray,
    cop: FloatArray,
    shares: FloatArray | tuple[float, float] = (0.0, 1.0),
) -> tuple[FloatArray, FloatArray]:
    """How CoPs (T, 2) in the left sole's frame [m] may come about.

    Args:
        robot: whose feet.
        right_rotation, right_translation: (T, 3, 3), (T, 3) pose of the right sole.
        cop: of both feet together.
        shares: (T, 2) or (2,) least and greatest share of the weight on the left foot.

    Returns:
        (T,) the left foot's share of the weight, and (T, 2, 2) the CoP of the left and of the
        right foot, both in the left sole's frame: each as far from its sensing polygon's middle.
    """
    left, right = (foot.sensing_polygon.mean(axis=0) for foot in robot.feet)
    right_middle = right_rotation[:, :2, :2] @ right + right_translation[:, :2]
    way = left - right_middle
    share = np.sum((cop - right_middle) * way, axis=1) / np.sum(way * way, axis=1)
    share = np.clip(share, *np.moveaxis(np.asarray(shares), -1, 0))
    aside = cop - (right_middle + share[:, None] * way)
    return share, np.stack([left + aside, right_middle + aside], axis=1)


def _holding_torques(
    robot: Robot,
    gravity: FloatArray,
    jacobians: FloatArray,
    feet: FloatArray,
    share: FloatArray,
    places: FloatArray,
) -> FloatArray:
    """(T, k) motor torques of the legs under gravity, held by vertical forces at both feet.

    Args:
        robot: whose legs.
        gravity: (T, 6 + m) generalised gravity [N m].
        jacobians: (T, 2, 6, 6 + m) of the joints that carry the feet, world axes.
        feet: (T, 2, 3) those joints' origins [m].
        share, places: as load_share gives them.
    """
    # Pinocchio's own gravity is rounded; forces and weights must balance.
    scale = GRAVITY / np.linalg.norm(robot.model.gravity.linear)
    forces = np.zeros((*feet.shape[:2], 6))
    forces[..., 2] = robot.weight * np.stack([share, 1.0 - share], axis=1)
    arms = places - feet[..., :2]
    # A vertical force f at an arm (x, y) has the moment (y f, -x f, 0).
    forces[..., 3] = arms[..., 1] * forces[..., 2]
    forces[..., 4] = -arms[..., 0] * forces[..., 2]
    torques = scale * gravity - np.einsum("tfcv,tfc->tv", jacobians, forces)
    joints = torques[:, 6:]
    for shared in robot.shared:
        joints[:, shared.leader] += shared.ratio * joints[:, shared.joint]
    motors: FloatArray = joints[:, robot.legs]
    return motors
