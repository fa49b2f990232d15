"""What a body does along a motion, by Pinocchio and numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.capsules import segment_distance
from shoecal_core.planning.load_sharing import SharingSpread
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot


@dataclass(frozen=True)
class BodyTrack:
    """T samples of a body, everything in the left sole's frame.

    Attributes:
        com: (T, 3) centre of mass [m].
        right_rotation: (T, 3, 3) turns vectors of the right sole's frame into the left's.
        right_translation: (T, 3) origin of the right sole [m].
        distances: (T, p) of the collision pairs [m].
        up: (T, 3) unit vector along the torso's upward axis.
        torques: (T, k) that the leg motors need to hold the posture [N m].
        loads: (T, 2) vertical force on left, right [N].
        foot_cop: (T, 2, 2) CoP of left, right, each in its own sole's frame; no number in the air
            [m].
        sideways: (T,) sideways force between the feet; zero on one foot [N].
        spread: half-width of the interval in which torques and loads lie; zero on one foot.
    """

    com: FloatArray
    right_rotation: FloatArray
    right_translation: FloatArray
    distances: FloatArray
    up: FloatArray
    torques: FloatArray
    loads: FloatArray
    foot_cop: FloatArray
    sideways: FloatArray
    spread: SharingSpread


def track(
    robot: Robot, positions: FloatArray, shares: FloatArray | tuple[float, float] = (0.0, 1.0)
) -> BodyTrack:
    """Follow all joint angles (T, m) [rad].

    Args:
        robot: whose body.
        positions: where its joints are.
        shares: (T, 2) or (2,) least and greatest share of the weight on the left foot: 0 and 1
            where both stand, twice the same on one foot.
    """
    model, count = robot.model, len(positions)
    data = model.createData()
    coms, ups = np.zeros((count, 3)), np.zeros((count, 3))
    rotations, translations = np.zeros((count, 3, 3)), np.zeros((count, 3))
    ends = np.zeros((count, len(robot.capsules), 2, 3))
    gravity, jacobians = np.zeros((count, model.nv)), np.zeros((count, 2, 6, model.nv))
    for index, angles in enumerate(positions):
        base = _standing(robot, data, angles)
        coms[index] = pin.centerOfMass(model, data, base)
        ups[index] = data.oMi[1].rotation[:, 2]
        pin.updateFramePlacements(model, data)
        right = data.oMf[robot.feet[1].frame]
        rotations[index], translations[index] = right.rotation, right.translation
        for capsule, end in zip(robot.capsules, ends[index], strict=True):
            pose = data.oMi[capsule.joint]
            end[:] = pose.act(capsule.start), pose.act(capsule.end)
        gravity[index] = pin.computeGeneralizedGravity(model, data, base)
        pin.computeJointJacobians(model, data, base)
        for side, foot in enumerate(robot.feet):
            jacobians[index, side] = pin.getFrameJacobian(
                model, data, foot.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
    # Pinocchio's own gravity is rounded; forces and weights must balance.
    gravity *= GRAVITY / np.linalg.norm(model.gravity.linear)
    shares = np.broadcast_to(np.asarray(shares, dtype=np.float64), (count, 2))
    motors = _motors(robot)
    wrenches, torques = _shared(robot, gravity, jacobians, shares, motors)
    relative = _relative(jacobians[..., 6:] @ motors.T, translations)
    both = np.ptp(shares, axis=1) > 0.0
    spread = SharingSpread.of(robot, relative)
    return BodyTrack(
        com=coms,
        right_rotation=rotations,
        right_translation=translations,
        distances=_distances(robot, ends),
        up=ups,
        torques=torques,
        loads=wrenches[:, :, 2],
        foot_cop=_foot_cop(wrenches, rotations),
        sideways=np.linalg.norm(wrenches[:, 1, :2], axis=1),
        spread=SharingSpread(
            both * spread.load, both * spread.sideways, both[:, None] * spread.torque
        ),
    )


def _foot_cop(wrenches: FloatArray, right: FloatArray) -> FloatArray:
    """See BodyTrack.foot_cop; wrenches (T, 2, 6) as of _shared, rotations (T, 3, 3)."""
    with np.errstate(invalid="ignore"):
        cop = np.stack([-wrenches[..., 4], wrenches[..., 3]], axis=-1) / wrenches[..., 2:3]
    cop[:, 1] = np.einsum("tji,tj->ti", right[:, :2, :2], cop[:, 1])
    return cop


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


def _motors(robot: Robot) -> FloatArray:
    """(k, m) how much each joint moves with each motor of the legs."""
    legs = robot.legs
    motors = np.zeros((len(legs), len(robot.joint_names)))
    motors[np.arange(len(legs)), legs] = 1.0
    for shared in robot.shared:
        motors[np.flatnonzero(legs == shared.leader), shared.joint] = shared.ratio
    return motors


def _relative(by_motor: FloatArray, right: FloatArray) -> FloatArray:
    """(T, 6, k) see LoadSharing.relative_jacobian.

    What the left sole's own motion does to the right one is taken off.

    Args:
        by_motor: (T, 2, 6, k) velocity and rate of turn of either sole by the motors' angles.
        right: (T, 3) origin of the right sole, that of the left one being zero [m].
    """
    left = by_motor[:, 0]
    moved = left[:, :3] + np.cross(left[:, 3:], right[..., None], axis=1)
    relative: FloatArray = by_motor[:, 1] - np.concatenate([moved, left[:, 3:]], axis=1)
    return relative


def _shared(
    robot: Robot,
    gravity: FloatArray,
    jacobians: FloatArray,
    shares: FloatArray,
    motors: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """The floor's wrenches on the feet by least work, and motor torques.

    See load_sharing; here the base's equations of balance and the motors' deflection energy are
    solved as one system.

    Args:
        robot: whose legs.
        gravity: (T, 6 + m) generalised gravity [N, N m].
        jacobians: (T, 2, 6, 6 + m) of the soles, world axes.
        shares: (T, 2) as for `track`.
        motors: (k, m) as _motors.

    Returns:
        (T, 2, 6) force [N] and moment [N m] on left, right about its own sole, and (T, k) torques
        [N m].
    """
    legs, count = robot.legs, len(gravity)
    stands = np.stack([shares[:, 1] > 0.0, shares[:, 0] < 1.0], axis=1)
    jacobians = jacobians * stands[:, :, None, None]
    stacked = jacobians.reshape(count, 12, -1)
    balance = stacked[:, :, :6]
    by_motor = stacked[:, :, 6:] @ motors.T
    compliance = 1.0 / robot.effort_limit[legs]
    # [B C B' A; A' 0] [w; multipliers] = [B C g; b]; a foot in the air has no wrench.
    system, known = np.zeros((count, 18, 18)), np.zeros((count, 18))
    system[:, :12, :12] = (by_motor * compliance) @ by_motor.swapaxes(1, 2)
    system[:, :12, 12:], system[:, 12:, :12] = balance, balance.swapaxes(1, 2)
    motor_gravity = gravity[:, 6:] @ motors.T
    known[:, :12] = (by_motor @ (compliance * motor_gravity)[..., None])[..., 0]
    known[:, 12:] = gravity[:, :6]
    air = np.repeat(~stands, 6, axis=1)
    system[:, np.arange(12), np.arange(12)] += air
    wrenches = np.linalg.solve(system, known[..., None])[:, :12, 0]
    torques = motor_gravity - (wrenches[:, None] @ by_motor)[:, 0]
    return np.stack([wrenches[:, :6], wrenches[:, 6:]], axis=1), torques
