"""The robot's body at each sample: places of links, torques, Jacobians."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.samples.momentum import base_in_stance
from shoecal_core.samples.samples import Samples

_STEP = 1e-5
"""rad; of central differences."""
POSE = 6
"""Numbers of the right sole's pose in the left's: x, y, z, roll, pitch, yaw."""


@dataclass(frozen=True)
class JointJacobians:
    """Derivatives by joint angles, at T samples and m joints.

    Attributes:
        cop: (T, 2, m) of the modelled CoP in the stance's frame [m/rad].
        closure: (T, 6, m) of the right sole's pose in the left's [m/rad, 1].
        tilt: (T, 2, m) of upwards (x, y) in the stance's sole frame, as an IMU measures it [1].
    """

    cop: FloatArray
    closure: FloatArray
    tilt: FloatArray


def closure(states: BodyStates) -> FloatArray:
    """(T, 6) pose of the right sole in the left's: x, y, z [m], roll, pitch, yaw [rad]."""
    rotation = states.rotation
    return np.column_stack(
        (
            states.translation,
            np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2]),
            -np.arcsin(np.clip(rotation[:, 2, 0], -1.0, 1.0)),
            states.yaw,
        )
    )


def up_in_sole(states: BodyStates, frame: IntArray, up: FloatArray) -> FloatArray:
    """(T, 3) upwards in the stance's sole frame, from upwards in the base's (T, 3)."""
    left = np.einsum("tji,tj->ti", states.left_rotation, up)
    right = np.einsum("tji,tj->ti", states.rotation, left)
    found: FloatArray = np.where((frame == 0)[:, None], left, right)
    return found


def joint_jacobians(samples: Samples) -> JointJacobians:
    """Central differences over the joints of the legs; zero for all others."""
    robot, frame = samples.robot, samples.frame
    kinematics = Kinematics(robot)
    rows = np.arange(len(frame))
    up = np.where(np.isfinite(samples.up), samples.up, 0.0)
    shape = (len(frame), len(robot.joint_names))
    cop, pose, tilt = (np.zeros((shape[0], size, shape[1])) for size in (2, POSE, 2))
    for joint in robot.moved:
        ends = []
        for sign in (1.0, -1.0):
            angles = samples.angles.copy()
            angles[:, joint] += sign * _STEP
            states = kinematics.states(angles)
            ends.append(
                (
                    states.com[rows, frame, :2],
                    closure(states),
                    up_in_sole(states, frame, up)[:, :2],
                )
            )
        for whole, high, low in zip((cop, pose, tilt), *ends, strict=True):
            whole[:, :, joint] = (high - low) / (2.0 * _STEP)
    return JointJacobians(cop, pose, tilt)


@dataclass(frozen=True)
class Links:
    """The robot's links at T samples, in the frame of the stance's sole.

    Attributes:
        names: of L links with a mass, the root first; what is fixed to a link is part of it.
        mass: (L,) [kg].
        rotation: (T, L, 3, 3) turns vectors of each link's frame.
        com: (T, L, 3) of each link [m].
        torque: (T, m) that motors hold with, as the vertical forces on the feet ask for [N m].
        side: (T, 2, 4, m) of each foot's force along x, y, z of its sole frame [m] and its moment
            about z [1]: how each joint's torque answers to it.
    """

    names: tuple[str, ...]
    mass: FloatArray
    rotation: FloatArray
    com: FloatArray
    torque: FloatArray
    side: FloatArray


def heavy_links(robot: Robot) -> list[tuple[int, pin.Frame]]:
    """Links with a mass, each with the number of the joint that moves it, the root first."""
    model = robot.model
    return [
        (joint, first_link(model, joint))
        for joint in range(1, model.njoints)
        if model.inertias[joint].mass > 0.0
    ]


def links(samples: Samples, foot_wrenches: FloatArray) -> Links:
    """Places and torques.

    Args:
        foot_wrenches: (T, 2, 3) measured on each foot, in its sole frame [N, N m].
    """
    robot = samples.robot
    model = robot.model
    data = model.createData()
    carried = heavy_links(robot)
    parent = [joint for joint, _ in carried]
    placed = [frame.placement for _, frame in carried]
    mass = np.array([model.inertias[joint].mass for joint in parent])
    lever = [np.asarray(model.inertias[joint].lever) for joint in parent]
    count, joints = len(samples.run), len(robot.joint_names)
    rotations = np.zeros((count, model.njoints, 3, 3))
    origins = np.zeros((count, model.njoints, 3))
    torque = np.zeros((count, joints))
    side = np.zeros((count, 2, 4, joints))
    still = np.zeros(model.nv)
    orientation, origin = base_in_stance(samples.states, samples.frame)
    for index in range(count):
        q = np.concatenate((origin[index], orientation[index], samples.angles[index]))
        pin.computeJointJacobians(model, data, q)
        for joint in range(1, model.njoints):
            pose = data.oMi[joint]
            rotations[index, joint], origins[index, joint] = pose.rotation, pose.translation
        generalised = pin.rnea(model, data, q, still, still).copy()
        for number, foot in enumerate(robot.feet):
            jacobian = pin.getJointJacobian(model, data, foot.joint, pin.ReferenceFrame.LOCAL)
            at_sole = foot.placement.inverse().toActionMatrix() @ jacobian
            force, about_x, about_y = foot_wrenches[index, number]
            wrench = np.array([0.0, 0.0, force, about_x, about_y, 0.0])
            generalised -= at_sole.T @ wrench
            side[index, number] = at_sole[[0, 1, 2, 5], 6:]
        torque[index] = generalised[6:]
    link_rotation = np.stack(
        [rotations[:, p] @ place.rotation for p, place in zip(parent, placed, strict=True)], axis=1
    )
    com = np.stack(
        [rotations[:, p] @ own + origins[:, p] for p, own in zip(parent, lever, strict=True)],
        axis=1,
    )
    names = tuple(str(frame.name) for _, frame in carried)
    return Links(names, mass, link_rotation, com, torque, side)


def driven_together(robot: Robot, joint: int) -> list[tuple[int, float]]:
    """A joint and those on its motor, with their ratios: one encoder measures them all."""
    shared = [(one.joint, one.ratio) for one in robot.shared if one.leader == joint]
    return [(joint, 1.0), *shared]
