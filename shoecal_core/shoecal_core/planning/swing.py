"""Lifting, moving and putting down one foot while the other one carries the robot."""

from __future__ import annotations

import math

import numpy as np
import shapely
from scipy.spatial.transform import Rotation, Slerp

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.segment import MotionSegment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.robot import Robot

_ASIDE = np.linspace(0.0, 0.12, 25)
"""m; how far to the side a foot may be led round the other one."""
_OUTWARD = np.arange(0.0, 0.04, 0.001)
"""m; how far outward a foot may be lifted."""
STEP_WAY, STEP_TURN = 0.005, 0.035
"""Way [m] and turn [rad] of a carried foot from state to state."""
_STATES_MIN = 6
"""Of a part of a way."""
_HASTE = 15.0 / 8.0
"""Greatest speed of a way that begins and ends without speed and acceleration, over its mean."""


class NoSwingPathError(ShoecalError):
    """A foot that cannot be carried past the other one."""


def swing_segment(
    name: str,
    aim: FloatArray,
    foot_poses: tuple[FootPose, ...],
    support_phase: SupportPhase,
    settings: PlannerSettings,
    *,
    pause: float = 0.0,
) -> MotionSegment:
    """A foot led along poses; the rest goes to an aim (5,) [m, -, m], standing foot's frame."""
    weights = settings.task_weights
    return MotionSegment(
        name, aim[None], weights, foot_poses, support_phase, settings.step_pace, pause
    )


def lifted(pose: FootPose, support_phase: SupportPhase, height: float) -> FootPose:
    """The foot that does not carry higher by `height` [m], and level."""
    swing = _of_swing(pose, support_phase)
    yaw = math.atan2(swing.rotation[1, 0], swing.rotation[0, 0])
    level = Rotation.from_euler("z", yaw).as_matrix()
    return _of_swing(
        FootPose(level, swing.translation + np.array([0.0, 0.0, height])), support_phase
    )


def swing_height(pose: FootPose, support_phase: SupportPhase) -> float:
    """Height of the foot in the air over the floor on which the other one is flat [m]."""
    return float(_of_swing(pose, support_phase).translation[2])


def stance_foot(pose: FootPose) -> tuple[SupportPhase, float]:
    """The foot that stands where one does, and how high the other one is above its floor [m].

    Soles that are tilted against each other look higher from one than from the other: the
    higher look counts.
    """
    return max(
        ((foot, swing_height(pose, foot)) for foot in (SupportPhase.LEFT, SupportPhase.RIGHT)),
        key=lambda found: found[1],
    )


def vertical_states(height: float) -> int:
    """States that lifting a foot takes."""
    return max(_STATES_MIN, math.ceil(_HASTE * height / STEP_WAY))


def interpolated_poses(
    begin: FootPose, end: FootPose, support_phase: SupportPhase, states: int, aside: float = 0.0
) -> tuple[FootPose, ...]:
    """Poses from one to another, both included, seen from the other foot; slow at both ends.

    Args:
        begin, end: of the right sole in the left sole's frame.
        support_phase: the foot that stands.
        states: steps from start to end.
        aside: how far the way bulges outward in its middle [m].
    """
    first, last = _of_swing(begin, support_phase), _of_swing(end, support_phase)
    even = np.linspace(0.0, 1.0, states + 1)
    parts = even**3 * (10.0 - 15.0 * even + 6.0 * even**2)
    ends = Rotation.from_matrix(np.stack([first.rotation, last.rotation]))
    turns = Slerp([0.0, 1.0], ends)(parts)
    places = first.translation + parts[:, None] * (last.translation - first.translation)
    outward = 1.0 if support_phase is SupportPhase.RIGHT else -1.0
    places[:, 1] += outward * aside * np.sin(np.pi * parts)
    inner = [
        _of_swing(FootPose(turn, place), support_phase)
        for turn, place in zip(turns.as_matrix(), places, strict=True)
    ]
    return (begin, *inner[1:-1], end)


def swing_path(
    robot: Robot,
    begin: FootPose,
    end: FootPose,
    support_phase: SupportPhase,
    settings: PlannerSettings,
) -> tuple[FootPose, ...]:
    """Up, along, down: poses that lead a foot past the other one without touching it.

    Gears give: a foot in the air hangs lower and nearer to the other one than encoders show. So
    it is led farther from it than where it stands.

    Args:
        robot: whose feet.
        begin, end: of the right sole in the left sole's frame, both on the floor.
        support_phase: the foot that stands.
        settings: lift, clearances, and the way from state to state.

    Raises:
        NoSwingPathError: when there is none.
    """
    if _gap(robot, (end,)) >= min(settings.foot_clearance, _gap(robot, (begin,))) - 1e-9:
        above, below = (_above(robot, pose, support_phase, settings) for pose in (begin, end))
        for aside in _ASIDE:
            along = _led(above, below, support_phase, aside)
            if _gap(robot, along) >= settings.step_clearance - 1e-9:
                return (
                    *_led(begin, above, support_phase, 0.0),
                    *along[1:],
                    *_led(below, end, support_phase, 0.0)[1:],
                )
    raise NoSwingPathError(
        "a foot cannot be carried past the other one without touching it; go by way of a wider "
        "double support"
    )


def _above(
    robot: Robot, pose: FootPose, support_phase: SupportPhase, settings: PlannerSettings
) -> FootPose:
    """A foot lifted from where it stands, and outward where it is too near to the other one."""
    up = lifted(pose, support_phase, settings.step_lift)
    for aside in _OUTWARD:
        moved = _outward(up, support_phase, aside)
        if _gap(robot, (moved,)) >= settings.step_clearance:
            return moved
    return up


def _outward(pose: FootPose, support_phase: SupportPhase, way: float) -> FootPose:
    """The foot in the air farther from the other one, to that one's side [m]."""
    swing = _of_swing(pose, support_phase)
    side = 1.0 if support_phase is SupportPhase.RIGHT else -1.0
    moved = swing.translation + np.array([0.0, side * way, 0.0])
    return _of_swing(FootPose(swing.rotation, moved), support_phase)


def _led(
    begin: FootPose,
    end: FootPose,
    support_phase: SupportPhase,
    aside: float,
) -> tuple[FootPose, ...]:
    """As interpolated_poses, in as many states as a carried foot takes."""
    first, last = _of_swing(begin, support_phase), _of_swing(end, support_phase)
    way = float(np.linalg.norm(last.translation - first.translation)) + math.pi * aside
    turn = Rotation.from_matrix(first.rotation.T @ last.rotation).magnitude()
    states = math.ceil(_HASTE * max(way / STEP_WAY, turn / STEP_TURN))
    return interpolated_poses(begin, end, support_phase, max(_STATES_MIN, states), aside)


def _gap(robot: Robot, poses: tuple[FootPose, ...]) -> float:
    """Least distance between the outlines of both feet, seen from above [m]."""
    left, right = (foot.outline for foot in robot.feet)
    others = shapely.polygons([pose.support.right_to_left(right) for pose in poses])
    return float(shapely.distance(shapely.Polygon(left), others).min())


def _of_swing(pose: FootPose, support_phase: SupportPhase) -> FootPose:
    """From the right sole in the left sole's frame to the one in the air, in the other's; back."""
    return pose.inverse if support_phase is SupportPhase.RIGHT else pose
