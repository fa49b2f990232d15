"""An independent check of a motion: Pinocchio, numpy and shapely instead of the planner's own.

It looks at every point of the trajectory, many more than there are planned states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError
from shoecal_core.model.robot import GRAVITY
from shoecal_core.planning.body_track import BodyTrack, track
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.settings import PlannerSettings

FloatArray = NDArray[np.float64]

_WINDOW = 0.1
"""s; accelerations are differences over this time, as the CoP feels them through a shoe."""
_TORQUE_SLACK = 1.02
"""Between planned states torques may exceed the planned ones by this factor."""
_RATE_SLACK = 1.1
"""Speeds and accelerations by differences may exceed the planned ones by this factor."""


@dataclass(frozen=True)
class Finding:
    """The worst of one constraint over a motion.

    Attributes:
        constraint: its name.
        unit: of value and limit.
        value: the worst.
        limit: that it must keep.
        excess: how far the value is beyond the limit; negative where it is kept.
        time: of the worst, from the motion's begin [s].
        where: joint, capsules or foot; empty where there is nothing to tell.
    """

    constraint: str
    unit: str
    value: float
    limit: float
    excess: float
    time: float
    where: str

    @property
    def kept(self) -> bool:
        """Whether the constraint holds throughout."""
        return self.excess <= 0.0

    def __str__(self) -> str:
        where = f" ({self.where})" if self.where else ""
        return (
            f"{self.constraint}{where} is {self.value:.4g} {self.unit} at {self.time:.2f} s, "
            f"limit {self.limit:.4g} {self.unit}"
        )


class CheckFailedError(ShoecalError):
    """A motion that violates a constraint.

    Attributes:
        findings: the violated ones.
    """

    def __init__(self, findings: tuple[Finding, ...]) -> None:
        self.findings = findings
        listed = "; ".join(str(finding) for finding in findings)
        super().__init__(
            f"the motion violates: {listed}; it was not released. Choose another double support "
            "or larger margins"
        )


@dataclass(frozen=True)
class Report:
    """Every constraint's worst over a motion."""

    findings: tuple[Finding, ...]

    @property
    def kept(self) -> bool:
        """Whether all constraints hold."""
        return all(finding.kept for finding in self.findings)

    def of(self, constraint: str) -> Finding:
        """The finding of one constraint."""
        return next(found for found in self.findings if found.constraint == constraint)

    def require(self) -> None:
        """Raise where a constraint is violated.

        Raises:
            CheckFailedError: names each with its time and value.
        """
        violated = tuple(finding for finding in self.findings if not finding.kept)
        if violated:
            raise CheckFailedError(violated)


def check_motion(legs: Legs, motion: Motion, settings: PlannerSettings) -> Report:
    """Check all constraints of planning.

    A motion may begin outside a margin (a robot is where it is), and then must not go farther
    out. Planned states keep the margins; between them `margin_kept` of each must be left.
    """
    time, positions = motion.time, motion.positions
    body = track(legs.robot, positions)
    return Report(
        (
            _stability(legs, motion, body, time, settings),
            _joint_limits(legs, positions, time, settings),
            *_collision(legs, body, time, settings),
            *_foot_transform(motion, body, time, settings),
            _joint_speed(legs, motion, settings),
            *_com(body, time, settings),
            _torque(legs, body, time, settings),
            _rest(motion, settings),
        )
    )


def _at_least(
    constraint: str,
    unit: str,
    values: FloatArray,
    limit: float,
    time: FloatArray,
    names: tuple[str, ...] = ("",),
) -> Finding:
    """The worst of values (T, n) that must not fall below a limit or their own begin."""
    allowed = np.minimum(limit, values[0])
    index, column = np.unravel_index(np.argmin(values - allowed), values.shape)
    value, bound = float(values[index, column]), float(allowed[column])
    return Finding(constraint, unit, value, bound, bound - value, float(time[index]), names[column])


def _at_most(
    constraint: str,
    unit: str,
    values: FloatArray,
    limit: FloatArray | float,
    time: FloatArray,
    names: tuple[str, ...] = ("",),
) -> Finding:
    """The worst of values (T, n) that must not exceed a limit, compared by their ratio."""
    limits = np.broadcast_to(limit, values.shape[1:])
    index, column = np.unravel_index(np.argmax(values / limits), values.shape)
    value, bound = float(values[index, column]), float(limits[column])
    return Finding(constraint, unit, value, bound, value - bound, float(time[index]), names[column])


def _stability(
    legs: Legs, motion: Motion, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> Finding:
    hull = sensing_hull(legs.robot, motion.support)
    points = shapely.points(body.com[:, :2])
    inside = np.where(
        shapely.contains(hull, points), shapely.distance(hull.exterior, points), np.inf
    )
    distance = np.where(np.isfinite(inside), inside, -shapely.distance(hull, points))
    return _at_least(
        "distance of the CoP from the edge of the sensing polygon",
        "m", distance[:, None],
        settings.stability_margin * settings.margin_kept, time,
    )  # fmt: skip


def _joint_limits(
    legs: Legs, positions: FloatArray, time: FloatArray, settings: PlannerSettings
) -> Finding:
    robot = legs.robot
    moved = [*robot.legs, *(shared.joint for shared in robot.shared)]
    room = np.minimum(positions - robot.lower, robot.upper - positions)[:, moved]
    names = tuple(robot.joint_names[index] for index in moved)
    return _at_least(
        "distance from joint limits",
        "rad", room, settings.joint_margin * settings.margin_kept, time, names,
    )  # fmt: skip


def _collision(
    legs: Legs, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> tuple[Finding, ...]:
    robot = legs.robot
    if not robot.collision_pairs:
        return ()
    names = tuple(
        f"{robot.capsules[a].name}, {robot.capsules[b].name}" for a, b in robot.collision_pairs
    )
    finding = _at_least(
        "distance between capsules",
        "m", body.distances,
        settings.capsule_clearance * settings.margin_kept, time, names,
    )  # fmt: skip
    return (finding,)


def _foot_transform(
    motion: Motion, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> tuple[Finding, Finding]:
    way = np.linalg.norm(body.right_translation - motion.foot_pose.translation, axis=1)
    between = motion.foot_pose.rotation.T @ body.right_rotation
    # |R - 1| = 2 sqrt(2) sin(angle / 2), well conditioned where the angle is small.
    chord = np.linalg.norm(between - np.eye(3), axis=(1, 2)) / (2.0 * np.sqrt(2.0))
    turn = 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))
    limit = settings.foot_drift
    return (
        _at_most("drift of the way between the feet", "m", way[:, None], limit, time),
        _at_most("drift of the turn between the feet", "rad", turn[:, None], limit, time),
    )


def _joint_speed(legs: Legs, motion: Motion, settings: PlannerSettings) -> Finding:
    robot = legs.robot
    steps = np.diff(motion.time)[:, None]
    speed = np.abs(np.diff(motion.positions, axis=0)) / steps
    limit = np.minimum(robot.velocity_limit, settings.joint_speed) * _RATE_SLACK
    return _at_most("joint speed", "rad/s", speed, limit, motion.time[:-1], robot.joint_names)


def _com(body: BodyTrack, time: FloatArray, settings: PlannerSettings) -> tuple[Finding, Finding]:
    ground = body.com[:, :2]
    half = max(1, round(_WINDOW / 2.0 / (time[1] - time[0])))
    wide = time[half] - time[0]
    speed = np.linalg.norm(ground[half:] - ground[:-half], axis=1) / wide
    bend = ground[2 * half :] - 2.0 * ground[half:-half] + ground[: -2 * half]
    shift = np.linalg.norm(bend, axis=1) / wide**2 * body.com[half:-half, 2] / GRAVITY
    return (
        _at_most(
            "CoM speed", "m/s", speed[:, None], settings.com_speed * _RATE_SLACK, time[:-half]
        ),
        _at_most(
            "shift of the CoP by acceleration", "m", shift[:, None],
            settings.dynamic_cop_error * _RATE_SLACK, time[half:-half],
        ),
    )  # fmt: skip


def _torque(legs: Legs, body: BodyTrack, time: FloatArray, settings: PlannerSettings) -> Finding:
    robot = legs.robot
    limit = np.maximum(
        robot.effort_limit[robot.legs] * settings.torque_share * _TORQUE_SLACK,
        np.abs(body.torques[0]),
    )
    return _at_most("static torque", "N m", np.abs(body.torques), limit, time, robot.leg_names)


def _rest(motion: Motion, settings: PlannerSettings) -> Finding:
    """How far the robot moves while it shall hold still."""
    points = int(settings.hold_time * settings.sample_rate)
    begin = np.abs(motion.positions[: points + 1] - motion.positions[0]).max(axis=1)
    end = np.abs(motion.positions[-1 - points :] - motion.positions[-1]).max(axis=1)
    moved = np.concatenate([begin, end])[:, None]
    time = np.concatenate([motion.time[: points + 1], motion.time[-1 - points :]])
    return _at_most("way while holding still", "rad", moved, 1e-6, time)
