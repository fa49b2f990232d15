"""A robot as data: its kinematic and mass model, feet, legs, capsules and foot range."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY

_SIDES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""(4, 2) directions to the front, left, rear and right of a sole."""


class JointsMissingError(ShoecalError):
    """Joint angles that do not belong to the robot file in use.

    Attributes:
        missing: joints of the robot that were not given.
        given: joints that were given.
    """

    def __init__(self, robot: str, missing: Sequence[str], given: Sequence[str]) -> None:
        self.missing = tuple(missing)
        self.given = tuple(given)
        listed = ", ".join(sorted(given)) or "none"
        super().__init__(
            f"robot '{robot}' needs joint(s) {', '.join(missing)}, but only these were given: "
            f"{listed}; record them, or check the robot file's joint names; joints outside the "
            "legs that stand still may be listed under 'optional_joints'"
        )


@dataclass(frozen=True)
class Foot:
    """One foot.

    Attributes:
        frame: index of its sole frame in the model.
        link: index of the frame in the model in which the robot file places that frame.
        joint: index of the model's joint that carries it.
        placement: the sole frame in that joint's frame.
        outline: (k, 2) convex outline of the sole, counter-clockwise, sole frame [m].
        sensing_polygon: (k, 2) where the CoP may be, counter-clockwise, sole frame [m].
    """

    frame: int
    link: int
    joint: int
    placement: pin.SE3
    outline: FloatArray
    sensing_polygon: FloatArray

    @property
    def sides(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Edges of the outline that look to the front, left, rear and right, in this order.

        Each side has outward unit normals n (e, 2) and offsets d (e,) [m]: what is on the sole has
        n @ p <= d. An edge across a corner counts to the side that it looks to most; a side that
        no edge looks to has the one that looks there least badly.
        """
        along = np.roll(self.outline, -1, axis=0) - self.outline
        along, begins = (part[np.any(along != 0.0, axis=1)] for part in (along, self.outline))
        normals = np.column_stack([along[:, 1], -along[:, 0]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = np.sum(normals * begins, axis=1)
        faces = normals @ _SIDES.T
        sides = []
        for side in range(4):
            mine = np.flatnonzero(np.argmax(faces, axis=1) == side)
            mine = mine if len(mine) else np.array([np.argmax(faces[:, side])])
            sides.append((normals[mine], offsets[mine]))
        return tuple(sides)

    @property
    def half_width(self) -> float:
        """Half the shorter side of the box around the sensing polygon [m]."""
        return 0.5 * float(np.ptp(self.sensing_polygon, axis=0).min())


def first_link(model: pin.Model, joint: int) -> pin.Frame:
    """The link that a joint moves; those fixed to it count as its parts."""
    own = [
        frame
        for frame in model.frames
        if frame.type == pin.FrameType.BODY and frame.parentJoint == joint
    ]
    return own[0]


@dataclass(frozen=True)
class SharedMotor:
    """A joint driven by another joint's motor: angle = ratio * leader's angle."""

    joint: int
    leader: int
    ratio: float


@dataclass(frozen=True)
class Capsule:
    """A link's shape: all points within `radius` of a segment.

    Attributes:
        name: for messages.
        joint: index of the model's joint that carries it.
        start, end: (3,) of the segment in that joint's frame [m].
        radius: [m].
    """

    name: str
    joint: int
    start: FloatArray
    end: FloatArray
    radius: float


@dataclass(frozen=True)
class JointDeflection:
    """How far a loaded joint may be from where its motor was commanded to.

    Attributes:
        sag: of servo, gears and brackets at the motor's torque limit [rad].
        play: backlash, the whole width of the dead band, and error of the zero together [rad].
    """

    sag: float = 0.03
    play: float = 0.006


@dataclass(frozen=True)
class SupportRange:
    """Where the right foot may stand relative to the left, as a grid.

    Attributes:
        lower, upper, step: (3,) of dx [m], dy [m], dtheta [rad].
        neutral: (3,) the double support of normal standing.
    """

    lower: FloatArray
    upper: FloatArray
    step: FloatArray
    neutral: FloatArray


@dataclass(frozen=True)
class Robot:
    """A humanoid on two feet, with the shoes it wears (if any) included.

    Arrays of joints have one entry a joint of the URDF, in `joint_names`' order.

    Attributes:
        name: of the robot.
        path, digest: the robot file and its SHA-256.
        urdf, urdf_digest: the URDF file and its SHA-256.
        model: Pinocchio model on a free-flying base, shoes included.
        mass: robot with shoes [kg].
        mass_std: its standard uncertainty [kg].
        feet: left, right.
        legs: (k,) indices of the joints that the planner moves; shared motors once.
        shared: joints that follow another joint's motor.
        posture: (m,) angles of joints that are not moved, and where planning starts [rad].
        optional: joints that may be absent from measurements; they are then at `posture`.
        capsules, collision_pairs: shapes, and pairs of indices that must not touch.
        support_range: allowed double supports.
        friction: coefficient of static friction that soles and floor have at least.
        deflection: of the joints under load.
        tilt_max: largest tilt of the torso that a motion may ask for [rad].
    """

    name: str
    path: Path
    digest: str
    urdf: Path
    urdf_digest: str
    model: pin.Model
    mass: float
    mass_std: float
    feet: tuple[Foot, Foot]
    legs: IntArray
    shared: tuple[SharedMotor, ...]
    posture: FloatArray
    optional: frozenset[str]
    capsules: tuple[Capsule, ...]
    collision_pairs: tuple[tuple[int, int], ...]
    support_range: SupportRange
    friction: float = 0.5
    deflection: JointDeflection = JointDeflection()
    tilt_max: float = 0.4

    @property
    def neutral(self) -> DoubleSupport:
        """The double support of normal standing."""
        return DoubleSupport(*map(float, self.support_range.neutral))

    @property
    def weight(self) -> float:
        """Weight of robot and shoes [N]."""
        return self.mass * GRAVITY

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Joints of the URDF, m of them."""
        return tuple(list(self.model.names)[2:])

    @cached_property
    def leg_names(self) -> tuple[str, ...]:
        """Joints that the planner moves."""
        return tuple(self.joint_names[index] for index in self.legs)

    @cached_property
    def moved(self) -> IntArray:
        """(k,) indices of the joints that the planner moves, those on shared motors included."""
        return np.array([*self.legs, *(shared.joint for shared in self.shared)], dtype=np.int64)

    @cached_property
    def between_feet(self) -> tuple[int, ...]:
        """Indices of the joints on the way from one sole to the other."""
        left, right = (set(self.model.supports[foot.joint]) for foot in self.feet)
        # Joint 0 of the model is the world, 1 the free base; both are above either foot.
        return tuple(sorted(int(joint) - 2 for joint in left ^ right if joint > 1))

    @cached_property
    def leg_chains(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Joints of the model from the hip to the sole, of the left and of the right leg."""
        left, right = (
            tuple(
                int(joint)
                for joint in self.model.supports[foot.joint]
                if joint - 2 in self.between_feet
            )
            for foot in self.feet
        )
        return left, right

    @property
    def lower(self) -> FloatArray:
        """(m,) lower joint limits [rad]."""
        return np.asarray(self.model.lowerPositionLimit)[7:]

    @property
    def upper(self) -> FloatArray:
        """(m,) upper joint limits [rad]."""
        return np.asarray(self.model.upperPositionLimit)[7:]

    @property
    def velocity_limit(self) -> FloatArray:
        """(m,) joint velocity limits [rad/s]."""
        return np.asarray(self.model.velocityLimit)[6:]

    @property
    def effort_limit(self) -> FloatArray:
        """(m,) joint torque limits [N m]."""
        return np.asarray(self.model.effortLimit)[6:]

    def joint(self, name: str) -> int:
        """Index of a joint in arrays of joints."""
        try:
            return self.joint_names.index(name)
        except ValueError:
            raise NameNotFoundError("joint", name, self.joint_names) from None

    def from_legs(self, leg_angles: FloatArray, others: FloatArray | None = None) -> FloatArray:
        """All joint angles (..., m) from the planned ones (..., k).

        Args:
            leg_angles: of `legs` [rad].
            others: (m,) angles of everything else; `posture` where not given.
        """
        if leg_angles.shape[-1] != len(self.legs):
            raise ShapeError("leg angles", f"(..., {len(self.legs)})", leg_angles.shape)
        base = self.posture if others is None else others
        angles = np.broadcast_to(base, (*leg_angles.shape[:-1], len(base))).copy()
        angles[..., self.legs] = leg_angles
        for shared in self.shared:
            angles[..., shared.joint] = shared.ratio * angles[..., shared.leader]
        return angles

    def from_measured(self, names: Sequence[str], positions: FloatArray) -> FloatArray:
        """All joint angles (..., m) from measured ones (..., len(names)), whatever their order.

        Joints that share a motor may be given once or twice; optional joints may be absent
        or NaN and are then taken at `posture`.

        Raises:
            JointsMissingError: when a joint is neither given nor derivable.
        """
        if positions.shape[-1] != len(names):
            raise ShapeError("positions", f"(..., {len(names)})", positions.shape)
        column = {name: index for index, name in enumerate(names)}
        angles = np.broadcast_to(
            self.posture, (*positions.shape[:-1], len(self.joint_names))
        ).copy()
        derivable = {shared.joint for shared in self.shared}
        missing = []
        for index, name in enumerate(self.joint_names):
            if name in column:
                value = positions[..., column[name]]
                if name in self.optional:
                    value = np.where(np.isfinite(value), value, self.posture[index])
                angles[..., index] = value
            elif name not in self.optional and index not in derivable:
                missing.append(name)
        if missing:
            raise JointsMissingError(self.name, missing, names)
        for shared in self.shared:
            if self.joint_names[shared.joint] not in column:
                angles[..., shared.joint] = shared.ratio * angles[..., shared.leader]
        return angles
