"""How two feet share the robot's load, and the motor torques that follow, as expressions.

On one foot statics alone gives the floor's wrench. On two feet it does not: a wrench that one foot
takes from the floor and the other gives back (six numbers, an internal wrench) changes neither the
sum of the forces nor that of the moments. What decides is how the legs deflect. Motors that hold
their angles, gears and brackets act as springs, and of all internal wrenches that one occurs for
which the deflection energy is least (Menabrea's theorem of least work; Timoshenko, "Strength of
materials", part I, chapter XI):

    minimise over w   sum c_i tau_i^2,   tau = tau_0 - J' w
    J C J' w = J C tau_0

with J (6, k) the velocity of the right sole relative to the left one by the motors' angles, and
C = diag(c) their compliances. For walking machines this is the stiffness matrix method (Gao and
Song, "Stiffness matrix method for foot force distribution of walking vehicles", 1992). Compliances
are taken in inverse proportion to the motors' torque limits; a common factor does not matter.

Joints are a little off their angles: play, zero errors, friction. Off by e they change the internal
wrench by (J C J')^-1 J e. So sharing is an interval: `SharingSpread` gives its half-width, which
constraints keep as a margin.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.symbolic import SymbolicKinematics, joint_axis

FRICTION_USED = 0.9
"""Of the friction that soles and floor have at least: motors that follow late take the rest."""
_SMOOTHING = 0.02
"""Of the weight; a sideways force is rounded off by so much, for its derivative at zero."""


class LoadSharing:
    """Loads of the feet and torques of the leg motors in one posture, both soles level.

    Attributes:
        relative_jacobian: (6, k) velocity and rate of turn of the right sole, seen from the left
            one, by the motors' angles, in the left sole's axes [m/rad, rad/rad].
        torques: (k, 1) of the leg motors, to hold the posture [N m].
        loads: (2, 1) vertical force on left, right [N].
        edges: (8, 1) moment by which left, right keep off tipping about the front, left, rear and
            right of their soles: load times the way to the foot's own CoP from the nearest edge
            of the outline that looks there [N m].
        grips: (2, 1) how much more sideways force left, right could take: usable friction times
            load, less the sideways force of the internal wrench [N].
    """

    def __init__(
        self, robot: Robot, body: SymbolicKinematics, foot_pose: ca.SX, share: ca.SX, cop: ca.SX
    ) -> None:
        """Write the expressions down.

        Args:
            robot: whose feet and motors.
            body: its kinematics.
            foot_pose: (12, 1) as FootPose.parameters.
            share: (2, 1) least and greatest share of the weight on the left foot: 0 and 1 where
                both stand, twice the same on one foot.
            cop: (2, 1) of both feet together, left sole's frame [m].
        """
        both = share[1] - share[0]
        limit = ca.DM(robot.effort_limit[robot.legs])
        jacobian = _relative_jacobian(robot, body)
        # Any way to stand in balance will do: the internal wrench corrects it.
        on_left = (share[0] + share[1]) / 2.0
        forces = _forces(robot, foot_pose, on_left, cop)
        rigid = _torques(robot, body, forces)
        compliant = jacobian @ ca.diag(1.0 / limit)
        wrench = both * _solve(compliant @ jacobian.T, compliant @ rigid)
        self.relative_jacobian = jacobian
        self.torques = rigid - jacobian.T @ wrench
        weight = robot.weight
        self.loads = ca.vertcat(on_left * weight - wrench[2], (1.0 - on_left) * weight + wrench[2])
        sideways = ca.sqrt(ca.sumsqr(wrench[:2]) + (_SMOOTHING * weight) ** 2)
        self.grips = FRICTION_USED * robot.friction * self.loads - both * sideways
        self.edges = _edges(robot, foot_pose, forces, self.loads, wrench)


@dataclass(frozen=True)
class SharingSpread:
    """Half-width of the interval in which the sharing of the load lies, for n postures.

    Attributes:
        load: (n,) of the vertical force on either foot [N].
        sideways: (n,) of the sideways force between the feet [N].
        torque: (n, k) of the leg motors [N m].
    """

    load: FloatArray
    sideways: FloatArray
    torque: FloatArray

    def scaled(self, factor: float) -> SharingSpread:
        """An interval that is wider by a factor."""
        return SharingSpread(factor * self.load, factor * self.sideways, factor * self.torque)

    def grip(self, friction: float) -> FloatArray:
        """(n,) half-width of what sideways force either foot could take more [N].

        Args:
            friction: usable coefficient.
        """
        # Joints are off independently of each other, and so are the two parts.
        width: FloatArray = np.hypot(friction * self.load, self.sideways)
        return width

    @classmethod
    def none(cls, robot: Robot) -> SharingSpread:
        """Of one posture on one foot."""
        return cls(np.zeros(1), np.zeros(1), np.zeros((1, len(robot.legs))))

    @classmethod
    def of(cls, robot: Robot, relative_jacobian: FloatArray) -> SharingSpread:
        """For joints that are off their angles by their play, independently of each other.

        Args:
            robot: its torque limits, and its joints' sag at them, give the compliances.
            relative_jacobian: (n, 6, k) as LoadSharing.relative_jacobian [m/rad, rad/rad].
        """
        limit = robot.effort_limit[robot.legs]
        if relative_jacobian.ndim != 3 or relative_jacobian.shape[1:] != (6, len(limit)):
            raise ShapeError("relative Jacobian", f"(n, 6, {len(limit)})", relative_jacobian.shape)
        compliance = robot.deflection.sag / limit
        turned = relative_jacobian.swapaxes(1, 2)
        stiffness = np.linalg.inv((relative_jacobian * compliance) @ turned)
        change = robot.deflection.play * stiffness @ relative_jacobian
        return cls(
            load=np.linalg.norm(change[:, 2], axis=1),
            sideways=np.linalg.norm(change[:, :2], ord=2, axis=(1, 2)),
            torque=np.linalg.norm(turned @ change, axis=2),
        )


def _forces(
    robot: Robot, foot_pose: ca.SX, on_left: ca.SX, cop: ca.SX
) -> list[tuple[ca.SX, ca.SX]]:
    """Share of the weight and place (3, 1) in the left sole's frame [m] of either foot's force."""
    left, right = (foot.sensing_polygon.mean(axis=0) for foot in robot.feet)
    rotation, translation = ca.reshape(foot_pose[:9], 3, 3), foot_pose[9:]
    middle_left = ca.SX(left)
    middle_right = rotation[:2, :2] @ right + translation[:2]
    aside = cop - (on_left * middle_left + (1.0 - on_left) * middle_right)
    return [
        (part, ca.vertcat(middle + aside, 0.0))
        for part, middle in ((on_left, middle_left), (1.0 - on_left, middle_right))
    ]


def _edges(
    robot: Robot,
    foot_pose: ca.SX,
    forces: list[tuple[ca.SX, ca.SX]],
    loads: ca.SX,
    wrench: ca.SX,
) -> ca.SX:
    """(8, 1) see LoadSharing.edges: the part of the contact wrench cone of a flat foot that is of
    its moments along the floor (Caron, Pham, Nakamura, "Stability of surface contacts for humanoid
    robots", 2015).
    """
    rotation, translation = ca.reshape(foot_pose[:9], 3, 3), foot_pose[9:]
    turns, origins = [ca.SX.eye(2), rotation[:2, :2]], [ca.SX.zeros(2), translation[:2]]
    # Acts at the right sole's origin; the left foot gives it back there.
    moved = ca.vertcat(-wrench[4], wrench[3]) + wrench[2] * translation[:2]
    margins = []
    for side, (part, place) in enumerate(forces):
        load, sign = loads[side], (-1.0, 1.0)[side]
        # Load times the way of the foot's own CoP from the sole's origin.
        about_origin = part * robot.weight * place[:2] + sign * moved - load * origins[side]
        moment = turns[side].T @ about_origin
        margins += [ca.mmin(load * ca.DM(d) - ca.DM(n) @ moment) for n, d in robot.feet[side].sides]
    edges: ca.SX = ca.vertcat(*margins)
    return edges


def _torques(robot: Robot, body: SymbolicKinematics, forces: list[tuple[ca.SX, ca.SX]]) -> ca.SX:
    """(k, 1) torques of the leg motors under vertical forces on the feet [N m].

    A motor holds what acts on its far side: the floor's force on the foot and the weight of
    all links between.
    """
    model = robot.model
    up = body.soles[0].rotation[:, 2]
    torques = [ca.SX(0) for _ in robot.joint_names]
    for foot, (part, place) in zip(robot.feet, forces, strict=True):
        at, load = body.soles[0].act(place), part * robot.weight
        for index in list(model.supports[foot.joint])[2:]:
            pose = body.joints[index]
            links = [model.inertias[link] for link in model.subtrees[index]]
            weight = GRAVITY * sum(inertia.mass for inertia in links)
            force = load - weight
            # Of all links at once: their moment about a point needs no more than the sum.
            held = load * at - GRAVITY * sum(
                inertia.mass * body.joints[link].act(np.asarray(inertia.lever))
                for link, inertia in zip(model.subtrees[index], links, strict=True)
            )
            moment = ca.cross(held - force * pose.translation, up)
            linear, angular = joint_axis(model, index)
            torques[index - 2] -= ca.dot(pose.rotation @ angular, moment)
            torques[index - 2] -= ca.dot(pose.rotation @ linear, up) * force
    for shared in robot.shared:
        torques[shared.leader] += shared.ratio * torques[shared.joint]
    motors: ca.SX = ca.vertcat(*(torques[index] for index in robot.legs))
    return motors


def _relative_jacobian(robot: Robot, body: SymbolicKinematics) -> ca.SX:
    """See LoadSharing.relative_jacobian."""
    model = robot.model
    left, right = body.soles
    columns = [ca.SX.zeros(6) for _ in robot.joint_names]
    for foot, sign in zip(robot.feet, (-1.0, 1.0), strict=True):
        for index in list(model.supports[foot.joint])[2:]:
            pose = body.joints[index]
            linear, angular = (pose.rotation @ axis for axis in joint_axis(model, index))
            velocity = linear + ca.cross(angular, right.translation - pose.translation)
            turned = (left.rotation.T @ velocity, left.rotation.T @ angular)
            columns[index - 2] += sign * ca.vertcat(*turned)
    for shared in robot.shared:
        columns[shared.leader] += shared.ratio * columns[shared.joint]
    jacobian: ca.SX = ca.horzcat(*(columns[index] for index in robot.legs))
    return jacobian


def _solve(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """Solution of a small symmetric positive definite system, written out."""
    diagonal, upper, order = ca.ldl(ca.densify(matrix))
    solution: ca.SX = ca.ldl_solve(right, diagonal, upper, order)
    return solution
