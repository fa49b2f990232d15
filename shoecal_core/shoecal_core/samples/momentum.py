"""The robot's angular momentum: with it a zero-moment point is that of the whole body.

The rate of the angular momentum L about the CoM moves the zero-moment point of a single mass by
    (-dL_y/dt, dL_x/dt) / (vertical force)
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET


def base_in_stance(states: BodyStates, frame: IntArray) -> tuple[FloatArray, FloatArray]:
    """Orientation (T, 4) x, y, z, w and origin (T, 3) [m] of the base in a foot's sole frame.

    Args:
        frame: (T,) the foot, 0 left, 1 right.
    """
    right = frame == 1
    rotation, origin = states.left_rotation.copy(), states.left_translation.copy()
    rotation[right] = (states.left_rotation @ states.rotation)[right]
    moved = np.einsum("tij,tj->ti", states.left_rotation, states.translation)
    origin[right] += moved[right]
    turned = rotation.transpose(0, 2, 1)
    place = -np.einsum("tij,tj->ti", turned, origin)
    quaternion = np.array([pin.Quaternion(one).coeffs() for one in turned])
    return quaternion, place


def angular_momentum(poses: FloatArray, time: FloatArray, robot: Robot) -> FloatArray:
    """(F, 3) of the whole body about its CoM, along the axes of the base's poses [N m s].

    Args:
        poses: (F, 7 + m) origin and orientation of the base, joint angles.
        time: (F,) [s].
    """
    last = len(poses) - 1
    data = robot.model.createData()
    found = np.zeros((len(poses), 3))
    for index, pose in enumerate(poses):
        before, after = max(index - 1, 0), min(index + 1, last)
        moved = pin.difference(robot.model, poses[before], poses[after])
        velocity = moved / (time[after] - time[before])
        found[index] = pin.computeCentroidalMomentum(robot.model, data, pose, velocity).angular
    return found


def standing_spin(
    angles: FloatArray, time: FloatArray, frame: IntArray, kinematics: Kinematics
) -> FloatArray:
    """(F, 2) what the angular momentum's rate adds to the CoP of a robot on a foot that stands [m].

    Args:
        angles: (F, m) of the joints, smooth enough to be differentiated twice [rad].
        time: (F,) [s].
        frame: (F,) foot that stands, in whose sole frame the result is.
    """
    robot, states = kinematics.robot, kinematics.states(angles)
    found = np.zeros((len(time), 2))
    for foot in range(len(FEET)):
        here = frame == foot
        if here.any():
            orientation, origin = base_in_stance(states, np.full(len(time), foot))
            poses = np.hstack((origin, orientation, angles))
            rate = np.gradient(angular_momentum(poses, time, robot), time, axis=0)
            found[here] = np.stack((-rate[:, 1], rate[:, 0]), axis=1)[here] / robot.weight
    return found
