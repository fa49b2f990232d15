"""An independent check of a motion: Pinocchio, numpy and shapely instead of the planner's own.

It looks at every point of the trajectory, many more than there are planned states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.planning.checking.body_track import BodyTrack, track
from shoecal_core.planning.checking.findings import (
    ConstraintMargin,
    Report,
    at_least,
    at_most,
    worst,
)
from shoecal_core.planning.deflection import deflected
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.load_sharing import FRICTION_USED
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET

_WINDOW = 0.1
"""s; accelerations are differences over this time, as the CoP feels them through a shoe."""
_TORQUE_SLACK = 1.02
"""Between planned states torques may exceed the planned ones by this factor."""
_TILT_SLACK = 1.02
"""Between planned states the torso may lean more than the planned ones by this factor."""
_LEVER_SLACK = 0.01
"""Of a sole's width; by so much the weight's lever may pass an edge between planned states."""
_NO_LOAD = 1e-3
"""N; a foot with less cannot take any sideways force."""
_DRAGGED = 0.006
"""m; a foot in the air that is farther than this from where it stood and will stand is carried."""
MARGIN_KEPT = 0.8
"""Part of each margin that is left between planned states, where they are joined."""
_RATE_SLACK = 1.1
"""Speeds and accelerations by differences may exceed the planned ones by this factor."""


def check_motion(legs: Legs, motion: Motion, settings: PlannerSettings) -> Report:
    """Check all constraints of planning.

    A motion may begin outside a margin (a robot is where it is), and then must not go farther
    out. Planned states keep the margins; between them MARGIN_KEPT of each must be left.

    Args:
        legs: of the robot.
        motion: to be released.
        settings: of planning; those of a phase follow from its pace.
    """
    spans = [_Span.of(motion, phase) for phase in motion.phases]
    shares = np.zeros((len(motion.time), 2))
    for span in spans:
        shares[span.samples] = span.phase.support_phase.share
    body = track(legs.robot, motion.positions, shares)
    sagging = body
    if any(span.phase.support_phase is not SupportPhase.BOTH for span in spans):
        true = deflected(legs.robot, motion.positions, body.torques)
        sagging = track(legs.robot, true, shares)
    found = [
        _joint_limits(legs, motion.positions, motion.time, settings),
        *_collision(legs, body, motion.time, settings),
        _torque(legs, body, motion.time, settings),
        _tilt(legs, body, motion.time),
        _rest(motion, settings),
    ]
    for span in spans:
        paced = settings.paced(span.phase.pace)
        found += [
            _stability(legs, span, body, motion.time, settings),
            *_feet(span, body, motion.time, settings),
            _joint_speed(legs, span, motion, paced),
            *_com(span, body, motion.time, paced),
            *_loads(legs, span, body, motion.time, settings),
        ]
        if span.phase.support_phase is not SupportPhase.BOTH:
            found += _swing_foot(legs, span, body, sagging, motion.time[span.samples], settings)
    return Report(worst(found))


@dataclass(frozen=True)
class _Span:
    """A phase and the samples that belong to it."""

    phase: Phase
    samples: slice

    @classmethod
    def of(cls, motion: Motion, phase: Phase) -> _Span:
        begin, end = np.searchsorted(motion.time, [phase.begin, phase.end])
        return cls(phase, slice(int(begin), int(end) + 1))

    @property
    def first(self) -> bool:
        """Whether the motion begins with it, wherever the robot then is."""
        return self.phase.begin == 0.0

    def seen_from_standing(self, body: BodyTrack) -> FloatArray:
        """(t, 3) CoM in the frame of a sole that stays where it is [m]."""
        com = body.com[self.samples]
        if self.phase.support_phase is not SupportPhase.RIGHT:
            return com
        return _in_right(body, self.samples, com)


def _in_right(body: BodyTrack, samples: slice, points: FloatArray) -> FloatArray:
    away = points - body.right_translation[samples]
    local: FloatArray = np.einsum("tji,tj->ti", body.right_rotation[samples], away)
    return local


def _stability(
    legs: Legs, span: _Span, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> ConstraintMargin:
    phase, robot = span.phase, legs.robot
    if phase.support_phase is SupportPhase.BOTH:
        polygon = phase.support_phase.polygon(robot, phase.foot_poses[0])
    else:
        polygon = shapely.Polygon(robot.feet[phase.support_phase.standing].sensing_polygon)
    points = shapely.points(span.seen_from_standing(body)[:, :2])
    distance = np.where(
        shapely.contains(polygon, points),
        shapely.distance(polygon.exterior, points),
        -shapely.distance(polygon, points),
    )
    return at_least(
        "distance of the CoP from the edge of the sensing polygon",
        "m", distance[:, None], phase.support_phase.margin(settings) * MARGIN_KEPT,
        time[span.samples],
        from_begin=span.first, slack=settings.foot_drift,
    )  # fmt: skip


def _joint_limits(
    legs: Legs, positions: FloatArray, time: FloatArray, settings: PlannerSettings
) -> ConstraintMargin:
    robot = legs.robot
    room = np.minimum(positions - robot.lower, robot.upper - positions)[:, robot.moved]
    names = tuple(robot.joint_names[index] for index in robot.moved)
    return at_least(
        "distance from joint limits",
        "rad", room, settings.joint_margin * MARGIN_KEPT, time, names,
        slack=settings.foot_drift,
    )  # fmt: skip


def _collision(
    legs: Legs, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> tuple[ConstraintMargin, ...]:
    robot = legs.robot
    if not robot.collision_pairs:
        return ()
    names = tuple(
        f"{robot.capsules[a].name}, {robot.capsules[b].name}" for a, b in robot.collision_pairs
    )
    finding = at_least(
        "distance between capsules",
        "m", body.distances,
        settings.capsule_clearance * MARGIN_KEPT, time, names,
        slack=settings.foot_drift,
    )  # fmt: skip
    return (finding,)


def _feet(
    span: _Span, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> list[ConstraintMargin]:
    """Feet that stay must stay; one in the air must leave from where it stood, and arrive."""
    if span.phase.support_phase is SupportPhase.BOTH:
        way, turn = _away(body, span.samples, span.phase.foot_poses[0])
        at = time[span.samples]
    else:
        ends = [span.samples.start, span.samples.stop - 1]
        aways = [
            _away(body, slice(index, index + 1), pose)
            for index, pose in zip(ends, span.phase.foot_poses, strict=True)
        ]
        way, turn = (np.concatenate(parts) for parts in zip(*aways, strict=True))
        at = time[ends]
    limit = settings.foot_drift
    return [
        at_most("drift of the way between the feet", "m", way[:, None], limit, at),
        at_most("drift of the turn between the feet", "rad", turn[:, None], limit, at),
    ]


def _away(body: BodyTrack, samples: slice, pose: FootPose) -> tuple[FloatArray, FloatArray]:
    """(t,) way [m] and turn [rad] of the right sole from a pose."""
    way = np.linalg.norm(body.right_translation[samples] - pose.translation, axis=1)
    between = pose.rotation.T @ body.right_rotation[samples]
    # |R - 1| = 2 sqrt(2) sin(angle / 2), well conditioned where the angle is small.
    chord = np.linalg.norm(between - np.eye(3), axis=(1, 2)) / (2.0 * np.sqrt(2.0))
    return way, 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))


def _swing_foot(
    legs: Legs,
    span: _Span,
    body: BodyTrack,
    sagging: BodyTrack,
    time: FloatArray,
    settings: PlannerSettings,
) -> list[ConstraintMargin]:
    """A foot in the air: no corner below the floor, and no overlap with the other foot.

    One that is carried along comes as high as it shall, however much the joints sag.
    """
    # The motion's start leads: a foot may be put down again where it stood.
    samples = np.concatenate([[0], np.arange(span.samples.start, span.samples.stop)])
    corners, gaps = _air(legs, span, body, samples)
    lowest = corners[..., 2].min(axis=1)
    middle = corners[1:, :, :2].mean(axis=1)
    way = np.linalg.norm(middle[:, None] - middle[[0, -1]], axis=2).min(axis=1)
    carried = way > _DRAGGED
    found = [
        at_least(
            "height of the foot in the air", "m", lowest[1:, None],
            _from_begin(0.0, lowest, settings), time, from_begin=False,
        ),
        at_least(
            "gap between the outlines of the feet", "m", gaps[1:, None],
            _from_begin(settings.foot_clearance * MARGIN_KEPT, gaps, settings), time,
            from_begin=False,
        ),
    ]  # fmt: skip
    if carried.any():
        name = "height of the foot that is carried along"
        values, least = lowest[1:][carried, None], settings.step_lift / 3.0
        found.append(at_least(name, "m", values, least, time[carried], from_begin=False))
        hanging = _air(legs, span, sagging, samples)[0][1:, :, 2].min(axis=1)
        top = [int(np.argmax(hanging))]
        name, least = "height to which a foot is truly lifted", settings.step_lift * MARGIN_KEPT
        found.append(at_least(name, "m", hanging[top, None], least, time[top], from_begin=False))
    return found


def _air(
    legs: Legs, span: _Span, body: BodyTrack, samples: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Corners (t, c, 3) of the lifted foot over the other's floor, gaps (t,) to its side [m]."""
    left, right = (
        np.column_stack([foot.outline, np.zeros(len(foot.outline))]) for foot in legs.robot.feet
    )
    right_in_left = (
        np.einsum("tij,cj->tci", body.right_rotation[samples], right)
        + body.right_translation[samples, None]
    )
    gaps = shapely.distance(shapely.Polygon(left[:, :2]), shapely.polygons(right_in_left[..., :2]))
    if span.phase.support_phase is SupportPhase.LEFT:
        return right_in_left, gaps
    local = left[None] - body.right_translation[samples, None]
    return np.einsum("tji,tcj->tci", body.right_rotation[samples], local), gaps


def _from_begin(limit: float, values: FloatArray, settings: PlannerSettings) -> float:
    """Of a foot that encoders may have shown as a little tilted or too near while it stood.

    Values are those at the motion's begin, and then from the phase's begin on.
    """
    return min(limit, float(values[0]), float(values[1])) - settings.foot_drift


def _joint_speed(
    legs: Legs, span: _Span, motion: Motion, settings: PlannerSettings
) -> ConstraintMargin:
    robot, time = legs.robot, motion.time[span.samples]
    speed = np.abs(np.diff(motion.positions[span.samples], axis=0)) / np.diff(time)[:, None]
    limit = np.minimum(robot.velocity_limit, settings.joint_speed * _RATE_SLACK)
    names = robot.joint_names
    return at_most("joint speed", "rad/s", speed, limit, time[:-1], names, rate=True)


def _com(
    span: _Span, body: BodyTrack, times: FloatArray, settings: PlannerSettings
) -> tuple[ConstraintMargin, ConstraintMargin]:
    time, com = times[span.samples], span.seen_from_standing(body)
    ground = com[:, :2]
    half = min(max(1, round(_WINDOW / 2.0 / (time[1] - time[0]))), (len(time) - 1) // 2)
    wide = time[half] - time[0]
    speed = np.linalg.norm(ground[half:] - ground[:-half], axis=1) / wide
    bend = ground[2 * half :] - 2.0 * ground[half:-half] + ground[: -2 * half]
    shift = np.linalg.norm(bend, axis=1) / wide**2 * com[half:-half, 2] / GRAVITY
    return (
        at_most(
            "CoM speed", "m/s", speed[:, None], settings.com_speed * _RATE_SLACK, time[:-half],
            rate=True,
        ),
        at_most(
            "shift of the CoP by acceleration", "m", shift[:, None],
            settings.dynamic_cop_error * _RATE_SLACK, time[half:-half], rate=True,
        ),
    )  # fmt: skip


def _torque(
    legs: Legs, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> ConstraintMargin:
    """However the feet share the load."""
    robot = legs.robot
    most = robot.effort_limit[robot.legs]
    held, margin = np.abs(body.torques), MARGIN_KEPT * body.spread.torque
    # From a start beyond the limit the torque must not grow; its interval may.
    begin = held[0] + margin.max(axis=0)
    limit = np.maximum(most * settings.torque_share, begin) * _TORQUE_SLACK
    limit = np.minimum(limit, most)
    return at_most("static torque", "N m", held + margin, limit, time, robot.leg_names)


def _tilt(legs: Legs, body: BodyTrack, time: FloatArray) -> ConstraintMargin:
    tilt = np.arccos(np.clip(body.up[:, 2:], -1.0, 1.0))
    # From a start that leans farther the tilt must not grow.
    limit = np.maximum(legs.robot.tilt_max, tilt[0]) * _TILT_SLACK
    return at_most("tilt of the torso", "rad", tilt, limit, time)


def _loads(
    legs: Legs, span: _Span, body: BodyTrack, time: FloatArray, settings: PlannerSettings
) -> tuple[ConstraintMargin, ...]:
    """Of feet that have to keep load: however they share it, enough of it, no slip, no tipping."""
    robot, feet = legs.robot, [index for index in (0, 1) if span.phase.loaded[index]]
    if span.phase.support_phase is not SupportPhase.BOTH or not feet:
        return ()
    names, at = tuple(FEET[index] for index in feet), time[span.samples]
    loads = body.loads[span.samples][:, feet]
    sure = loads - MARGIN_KEPT * body.spread.load[span.samples, None]
    usable = FRICTION_USED * robot.friction
    grip = MARGIN_KEPT * body.spread.grip(usable)[span.samples, None] / usable
    pressed = loads - grip
    ratio = body.sideways[span.samples, None] / np.maximum(pressed, _NO_LOAD)
    slip = np.full(len(feet), usable)
    if span.first:
        slip = np.maximum(slip, ratio[0])
    lever = _inside(robot, body.foot_cop[span.samples])[:, feet] * loads / robot.weight
    widths = np.array([np.ptp(robot.feet[index].outline, axis=0).min() for index in feet])
    beyond = -_LEVER_SLACK * widths
    least = settings.load_share * robot.weight
    return (
        at_least("load of a foot that stands", "N", sure, least, at, names, from_begin=span.first),
        at_least(
            "lever of the weight from the edge of a sole",
            "m",
            lever,
            beyond,
            at,
            names,
            from_begin=span.first,
        ),
        at_most("sideways force over load of a foot", "", ratio, slip, at, names),
    )


def _inside(robot: Robot, cops: FloatArray) -> FloatArray:
    """(t, 2) from the edge of either sole to its foot's CoP (t, 2, 2); negative outside [m]."""
    found = []
    for foot, cop in zip(robot.feet, cops.swapaxes(0, 1), strict=True):
        ways = [d - cop @ n.T for n, d in foot.sides]
        found.append(np.hstack(ways).min(axis=1))
    return np.column_stack(found)


def _rest(motion: Motion, settings: PlannerSettings) -> ConstraintMargin:
    """How far the robot moves while it shall hold still."""
    points = int(settings.hold_time * settings.sample_rate)
    begin = np.abs(motion.positions[: points + 1] - motion.positions[0]).max(axis=1)
    end = np.abs(motion.positions[-1 - points :] - motion.positions[-1]).max(axis=1)
    moved = np.concatenate([begin, end])[:, None]
    time = np.concatenate([motion.time[: points + 1], motion.time[-1 - points :]])
    return at_most("way while holding still", "rad", moved, 1e-6, time)
