"""The legs as the planner sees them: what moves, how far, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.capsules import segment_distance_squared
from shoecal_core.planning.freedom import held_way
from shoecal_core.planning.load_sharing import FRICTION_USED, LoadSharing, SharingSpread
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Foot, Robot
from shoecal_core.robot.symbolic import SymbolicKinematics
from shoecal_core.settings import SettingError
from shoecal_core.shoe.shoe import FEET

BALANCE_NAMES = (
    "load on left", "load on right", "grip of left", "grip of right",
    *(
        f"CoP of {foot} behind the {edge} edge of its sole"
        for foot in FEET for edge in ("front", "left", "rear", "right")
    ),
    "tilt of the torso",
)  # fmt: skip
"""What LegExpressions.balance lists, for people."""
BALANCE = len(BALANCE_NAMES)
BALANCE_EDGES = slice(4, 12)
"""Of it: what keeps the feet flat."""
_LEAST_JOINTS = 8
"""Both feet in place take six of them, the CoP two."""
_AT_KNEE = 0.01
"""m; joints nearer to a knee than this are a part of it."""


class LegsError(ShoecalError):
    """Legs that cannot be planned with."""


@dataclass(frozen=True)
class FootPose:
    """Pose of the right sole in the left sole's frame, in space.

    Attributes:
        rotation: (3, 3) turns vectors of the right sole's frame into the left's.
        translation: (3,) origin of the right sole [m].
    """

    rotation: FloatArray
    translation: FloatArray

    @classmethod
    def of(cls, support: DoubleSupport) -> FootPose:
        """Both soles flat on one floor."""
        rotation = np.eye(3)
        rotation[:2, :2] = support.rotation
        return cls(rotation, np.array([support.dx, support.dy, 0.0]))

    @property
    def inverse(self) -> FootPose:
        """Pose of the left sole in the right sole's frame."""
        return FootPose(self.rotation.T, -self.rotation.T @ self.translation)

    @property
    def support(self) -> DoubleSupport:
        """Its part on the floor."""
        yaw = np.arctan2(self.rotation[1, 0], self.rotation[0, 0])
        return DoubleSupport(float(self.translation[0]), float(self.translation[1]), float(yaw))

    @property
    def parameters(self) -> FloatArray:
        """(12,) rotation by columns, then translation [m]: the order LegExpressions wants."""
        return np.concatenate([self.rotation.T.ravel(), self.translation])


@dataclass(frozen=True)
class Knee:
    """The joint of a leg that changes its length most.

    Attributes:
        column: its place in arrays of leg joints.
        straight: angle at which the leg is longest [rad].
    """

    column: int
    straight: float


class LegExpressions:
    """What the constraints and costs of planning are made of, in one posture.

    Attributes:
        angles: (k, 1) symbol of the leg angles [rad].
        others: (m, 1) symbol of all joint angles, of which those outside the legs count.
        foot_pose: (12, 1) symbol of a pose between the feet, as FootPose.parameters.
        share: (2, 1) symbol of the least and greatest share of the weight on the left foot.
        cop: (2, 1) ground projection of the CoM in the left sole's frame [m].
        foot_error: (6, 1) how far the right sole is from that pose: way [m], turn [rad].
        distances: (p, 1) of the robot's collision pairs [m].
        balance: (13, 1) vertical force on left and right, how much more sideways force left and
            right could take, by how much either keeps off its edges, all over the weight; and the
            cosine of the torso's tilt.
        torques: (k, 1) of the leg motors, to hold the posture [N m].
        relative_jacobian: (6, k) see LoadSharing.
        lean: (2, 1) direction of the torso's upward axis along the floor; zero when upright.
        height: of the base above the left sole [m].
    """

    def __init__(self, robot: Robot) -> None:
        self.angles = ca.SX.sym("legs", len(robot.legs))
        self.others = ca.SX.sym("others", len(robot.joint_names))
        self.foot_pose = ca.SX.sym("foot_pose", 12)
        self.share = ca.SX.sym("share", 2)
        body = SymbolicKinematics(robot, _all_angles(robot, self.angles, self.others))
        left, right = body.soles
        self.cop = left.inverse_act(body.com)[:2]
        rotation = left.rotation.T @ right.rotation
        wanted = ca.reshape(self.foot_pose[:9], 3, 3)
        turn = wanted.T @ rotation
        turned = (turn - turn.T) / 2.0
        self.foot_error = ca.vertcat(
            left.inverse_act(right.translation) - self.foot_pose[9:],
            turned[2, 1], turned[0, 2], turned[1, 0],
        )  # fmt: skip
        self.lean = left.rotation.T[:2, 2]
        self.height = left.inverse_act(ca.SX.zeros(3))[2]
        self.distances = _distances(robot, body)
        sharing = LoadSharing(robot, body, self.foot_pose, self.share, self.cop)
        self.torques, self.relative_jacobian = sharing.torques, sharing.relative_jacobian
        forces = ca.vertcat(sharing.loads, sharing.grips, sharing.edges) / robot.weight
        self.balance = ca.vertcat(forces, left.rotation.T[2, 2])


def least_balance(
    robot: Robot, settings: PlannerSettings, loaded: BoolArray, spread: SharingSpread
) -> FloatArray:
    """(n, 13) least of what LegExpressions.balance lists, however the feet share the load.

    Args:
        robot: its friction and its torso's largest tilt.
        settings: least share of the load.
        loaded: (n, 2) whether left, right have to keep load and grip, and stay flat.
        spread: of the sharing, of one posture.
    """
    load = settings.load_share + spread.load[0] / robot.weight
    grip = spread.grip(FRICTION_USED * robot.friction)[0] / robot.weight
    feet = np.where(np.tile(loaded, 2), [load, load, grip, grip], -np.inf)
    edges = np.where(np.repeat(loaded, 4, axis=1), 0.0, -np.inf)
    # Play of an ankle and a hip, and knees that sag unevenly, lean the torso farther; the latter
    # hardly do while the weight goes over to one foot.
    joint = robot.deflection
    less = 2.0 * joint.play + np.where(loaded.all(axis=1), joint.sag, 0.0)
    tilt = np.maximum(0.1 * robot.tilt_max, robot.tilt_max - less)
    return np.column_stack([feet, edges, np.cos(tilt)])


class Legs:
    """The moved joints of one robot and the functions of them that planning needs.

    Holding one means that they have been written out.

    Raises:
        LegsError: for legs that cannot move the CoP both ways while both feet stay, or without
            limits.

    Attributes:
        robot: whose legs.
        kinematics: of the whole robot, for batches.
        knees: left, right.
    """

    def __init__(self, robot: Robot) -> None:
        _check(robot)
        self.robot = robot
        self.kinematics = Kinematics(robot)
        self.knees = (_knee(robot, 0), _knee(robot, 1))

    @cached_property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """(k,), (k,) range of each motor, its other joints' limits included [rad]."""
        robot = self.robot
        lower, upper = robot.lower.copy(), robot.upper.copy()
        for shared in robot.shared:
            ends = np.sort([bound[shared.joint] / shared.ratio for bound in (lower, upper)])
            lower[shared.leader] = max(lower[shared.leader], ends[0])
            upper[shared.leader] = min(upper[shared.leader], ends[1])
        return lower[robot.legs], upper[robot.legs]

    @property
    def nominal(self) -> FloatArray:
        """(k,) leg angles of the robot's own posture [rad]."""
        return self.robot.posture[self.robot.legs]

    def bounds(
        self, settings: PlannerSettings, extra: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """(k,), (k,) range of each motor less its margins, knees bent [rad].

        Args:
            settings: joint_margin and knee_margin.
            extra: margin beyond those [rad].
        """
        margin = settings.joint_margin + extra
        lower, upper = (limit.copy() for limit in self.limits)
        lower, upper = lower + margin, upper - margin
        for knee in self.knees:
            bend = settings.knee_margin + extra
            if self.nominal[knee.column] > knee.straight:
                lower[knee.column] = max(lower[knee.column], knee.straight + bend)
            else:
                upper[knee.column] = min(upper[knee.column], knee.straight - bend)
        for name, low, high in zip(self.robot.leg_names, lower, upper, strict=True):
            if low >= high:
                raise SettingError(
                    "joint_margin",
                    f"{margin:g} rad leaves joint '{name}' no room to move; lower it",
                )
        return lower, upper

    def foot_pose(self, joint_angles: FloatArray) -> FootPose:
        """Pose between the feet at all joint angles (m,) [rad]."""
        state = self.kinematics.states(joint_angles[None])
        return FootPose(state.rotation[0], state.translation[0])

    def cop(self, joint_angles: FloatArray) -> FloatArray:
        """(T, 2) modelled CoP in the left sole's frame at all joint angles (T, m) [m]."""
        return self.kinematics.states(joint_angles).cop[:, 0]


def _check(robot: Robot) -> None:
    if len(robot.legs) < _LEAST_JOINTS:
        raise LegsError(
            f"{robot.path}: legs: {len(robot.legs)} joints cannot move the CoP while both feet "
            f"stay; list at least {_LEAST_JOINTS}"
        )
    for side, foot in zip(FEET, robot.feet, strict=True):
        if not _chain(robot, foot):
            raise LegsError(f"{robot.path}: legs: none of them moves the {side} foot; list its leg")
    if way := held_way(robot):
        raise LegsError(
            f"{robot.path}: legs: while both soles stay flat, they cannot move the CoP {way}; list "
            "every joint of both legs, or calibrate the shoes with known weights (`shoecal manual`)"
        )
    for kind, limits in (("effort", robot.effort_limit), ("velocity", robot.velocity_limit)):
        for name, limit in zip(robot.leg_names, limits[robot.legs], strict=True):
            if not limit > 0.0:
                raise LegsError(
                    f"{robot.urdf}: joint {name}: the {kind} limit is {limit:g}; give its motor's"
                )


def _all_angles(robot: Robot, legs: ca.SX, others: ca.SX) -> ca.SX:
    """As Robot.from_legs, in symbols."""
    angles = [others[index] for index in range(len(robot.joint_names))]
    for column, index in enumerate(robot.legs):
        angles[index] = legs[column]
    for shared in robot.shared:
        angles[shared.joint] = shared.ratio * angles[shared.leader]
    return ca.vertcat(*angles)


def _distances(robot: Robot, body: SymbolicKinematics) -> ca.SX:
    ends = [
        [body.joints[capsule.joint].act(point) for point in (capsule.start, capsule.end)]
        for capsule in robot.capsules
    ]
    rows = []
    for a, b in robot.collision_pairs:
        squared = segment_distance_squared(*ends[a], *ends[b])
        radii = robot.capsules[a].radius + robot.capsules[b].radius
        rows.append(ca.sqrt(ca.fmax(squared, 1e-12)) - radii)
    return ca.vertcat(*rows) if rows else ca.SX.zeros(0, 1)


def _chain(robot: Robot, foot: Foot) -> list[int]:
    """The moved joints between torso and foot, by index into arrays of joints."""
    moved = {*robot.legs, *(shared.joint for shared in robot.shared if shared.leader in robot.legs)}
    return [index - 2 for index in robot.model.supports[foot.joint] if index - 2 in moved]


def _knee(robot: Robot, foot: int) -> Knee:
    """Found by how each joint changes the distance from the leg's first joint to its last.

    Hips and ankles turn about axes that (nearly) meet there, so they hardly change it. Straight is
    where the joints above and below the knee are farthest apart.
    """
    chain = _chain(robot, robot.feet[foot])
    leader = {shared.joint: shared.leader for shared in robot.shared}
    angles = ca.SX.sym("q", len(robot.joint_names))
    body = SymbolicKinematics(robot, angles)
    places = [body.joints[index + 2].translation for index in chain]
    rate = ca.Function("rate", [angles], [ca.gradient(ca.norm_2(places[-1] - places[0]), angles)])
    fan = np.linspace(0.1, 0.9, 9)[:, None]
    samples = robot.lower + fan * (robot.upper - robot.lower)
    change = np.abs(np.array(rate(samples.T))).mean(axis=1)
    joint = max(chain, key=lambda index: float(change[index]))
    grid = np.tile(robot.posture, (2001, 1))
    grid[:, joint] = np.linspace(robot.lower[joint], robot.upper[joint], 2001)
    above, below = _ends(robot, angles, places, chain.index(joint))
    length = ca.Function("length", [angles], [ca.norm_2(below - above)])
    column = list(robot.legs).index(leader.get(joint, joint))
    return Knee(column, float(grid[np.argmax(np.array(length(grid.T)).ravel()), joint]))


def _ends(robot: Robot, angles: ca.SX, places: list[ca.SX], knee: int) -> tuple[ca.SX, ca.SX]:
    """Places of the nearest joints above and below a knee that are not at the knee itself."""
    apart = ca.horzcat(*[ca.norm_2(place - places[knee]) for place in places])
    away = np.array(ca.Function("apart", [angles], [apart])(robot.posture)).ravel() > _AT_KNEE
    above, below = np.flatnonzero(away[:knee]), knee + np.flatnonzero(away[knee:])
    return (
        places[above[-1] if len(above) else 0],
        places[below[0] if len(below) else len(places) - 1],
    )
