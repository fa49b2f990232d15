"""The motions that calibration and diagnosis ask for by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.posture import middle
from shoecal_core.planning.segment import MotionSegment, cop_segment, in_left, in_standing
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import (
    interpolated_poses,
    lifted,
    swing_height,
    swing_segment,
    vertical_states,
)
from shoecal_core.robot.robot import Robot

FASTER = 1.8
"""Pace of motions that win by where they lead, not by how often that is sampled. The CoM's
acceleration then shifts the CoP by 1.3 mm at most; at 2 gears strike more than they win."""


@dataclass(frozen=True)
class InitialStance:
    """Where a motion begins.

    Attributes:
        robot: that stands on both feet, or on one.
        settings: of planning.
        foot_pose: of the right sole in the left sole's frame.
        tasks: (5,) CoP in the left sole's frame [m], lean, height of the base [m].
        on_one: the same for standing on one foot, the feet in a pose.
        within_reach: moves places (L, 2) for the CoP on these feet in to where it can be; NaN
            where that is nowhere.
        support_phase: the feet that stand.
    """

    robot: Robot
    settings: PlannerSettings
    foot_pose: FootPose
    tasks: FloatArray
    on_one: Callable[[FootPose, SupportPhase], FloatArray]
    within_reach: Callable[[FloatArray], FloatArray]
    support_phase: SupportPhase = SupportPhase.BOTH

    @property
    def cop(self) -> FloatArray:
        """(2,) left sole's frame [m]."""
        return self.tasks[:2]

    @cached_property
    def contour(self) -> Contour:
        """Of the landmarks, as far out as the robot can have its CoP."""
        corners = Contour.of(self.robot, self.foot_pose.support).corners
        found = self.within_reach(corners)
        # A robot that stands outside its margins is led towards the landmark itself.
        return Contour(np.where(np.isnan(found), corners, found))

    def pursuing(
        self,
        name: str,
        targets: FloatArray,
        loaded: SupportPhase = SupportPhase.BOTH,
        pace: float = 1.0,
    ) -> MotionSegment:
        """Targets (L, 5) on both feet, the torso's lean and height among them.

        Args:
            name: of the segment.
            targets: CoP [m], lean, height [m].
            loaded: the feet that have to keep load: not one that is, or was, in the air.
            pace: factor on all speeds.
        """
        weights = self.settings.task_weights
        return MotionSegment(
            name, targets, weights, (self.foot_pose,), pace=pace, loaded=loaded.feet
        )


@dataclass(frozen=True)
class MotionKind:
    """An entry of the motion catalogue.

    Attributes:
        doc: what it is, for people.
        segments: what it is made of, from where it begins.
        streams: whether it is one segment of places for the CoP, and so can be planned part by
            part, each from where the robot has come to.
        on_one: whether it begins on one foot.
    """

    doc: str
    segments: Callable[[InitialStance], tuple[MotionSegment, ...]]
    streams: bool = False
    on_one: bool = False


def motion_kind(name: str) -> MotionKind:
    """An entry of the motion catalogue.

    Raises:
        NameNotFoundError: for a motion that is not on it.
    """
    known = {**MOTION_KINDS, PUT_DOWN: _PUT_DOWN_KIND}
    if name not in known:
        raise NameNotFoundError("motion", name, tuple(known))
    return known[name]


def _round(
    standing: InitialStance, name: str, *, clockwise: bool = False, pace: float = 1.0
) -> tuple[MotionSegment, ...]:
    """From landmark to landmark, the torso free."""
    contour, cop = standing.contour, standing.cop
    places = contour.reversed_targets(cop) if clockwise else contour.targets(cop)
    return (cop_segment(name, places, standing.foot_pose, standing.settings, pace=pace),)


def _hold(standing: InitialStance) -> tuple[MotionSegment, ...]:
    settings = standing.settings
    return tuple(
        dataclasses.replace(
            cop_segment("hold", place[None], standing.foot_pose, settings),
            pause=settings.dwell_time,
        )
        for place in standing.contour.targets(standing.cop)[1:]
    )


def _tilt(standing: InitialStance) -> tuple[MotionSegment, ...]:
    """Forward, back, left, right, upright again, the CoP and the height as they are."""
    ways = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]], dtype=np.float64)
    targets = np.tile(standing.tasks, (len(ways), 1))
    targets[:, 2:4] = standing.settings.tilt * ways
    return (standing.pursuing("torso_tilt", targets),)


def _height(standing: InitialStance) -> tuple[MotionSegment, ...]:
    """Down, round the landmarks there, up again; the torso may lean for it."""
    low = standing.tasks - [0.0, 0.0, 0.0, 0.0, standing.settings.sink]
    places = standing.contour.targets(standing.cop)
    around = np.tile(low, (len(places), 1))
    around[:, :2] = places
    whole = standing.pursuing("torso_height", np.vstack([low, around, low, standing.tasks]))
    weights = whole.weights * [1.0, 1.0, 0.0, 0.0, 1.0]
    return (dataclasses.replace(whole, weights=weights),)


def _unload(standing: InitialStance, support_phase: SupportPhase) -> tuple[MotionSegment, ...]:
    """The weight over one foot, the other lifted a little and put down, the weight back."""
    settings, pose = standing.settings, standing.foot_pose
    tasks = standing.on_one(pose, support_phase)
    up = interpolated_poses(
        pose,
        lifted(pose, support_phase, settings.lift),
        support_phase,
        vertical_states(settings.lift),
    )
    aim = in_standing(tasks, pose, support_phase)
    return (
        standing.pursuing("shift", tasks[None], support_phase, FASTER),
        swing_segment("lift", aim, up, support_phase, settings, pause=settings.unloaded_time),
        swing_segment("lower", aim, up[::-1], support_phase, settings),
        standing.pursuing("back", standing.tasks[None], support_phase, FASTER),
    )


def _put_down(standing: InitialStance) -> tuple[MotionSegment, ...]:
    """Straight down with the foot in the air, everything else as it is; the weight back."""
    settings, pose, support_phase = standing.settings, standing.foot_pose, standing.support_phase
    height = swing_height(pose, support_phase)
    down = lifted(pose, support_phase, -height)
    states = vertical_states(height)
    aim = in_standing(standing.tasks, pose, support_phase)
    ended = in_left(aim, down, support_phase)
    ended[:2] = middle(standing.robot, down.support)
    ended[2:4] = 0.0
    back = MotionSegment(
        "back", ended[None], settings.task_weights, (down,), loaded=support_phase.feet
    )
    return (
        swing_segment(
            "lower",
            aim,
            interpolated_poses(pose, down, support_phase, states),
            support_phase,
            settings,
        ),
        back,
    )


PUT_DOWN = "put_down"
"""Not in the catalogue: what a robot does that was stopped on one foot."""
_PUT_DOWN_KIND = MotionKind(
    "the foot in the air put down, the weight back over both", _put_down, on_one=True
)

MOTION_KINDS: Mapping[str, MotionKind] = {
    "landmarks": MotionKind(
        "landmark to landmark, counter-clockwise", lambda at: _round(at, "landmarks"), streams=True
    ),
    "reversed": MotionKind(
        "landmark to landmark, clockwise",
        lambda at: _round(at, "reversed", clockwise=True),
        streams=True,
    ),
    "faster": MotionKind(
        "landmark to landmark, counter-clockwise, 1.8 times as fast",
        lambda at: _round(at, "faster", pace=FASTER),
    ),
    "faster_reversed": MotionKind(
        "landmark to landmark, clockwise, 1.8 times as fast",
        lambda at: _round(at, "faster_reversed", clockwise=True, pace=FASTER),
    ),
    "hold": MotionKind("landmark to landmark, standing still at each", _hold),
    "unload_left": MotionKind(
        "the left foot lifted a little, for a moment", lambda at: _unload(at, SupportPhase.RIGHT)
    ),
    "unload_right": MotionKind(
        "the right foot lifted a little, for a moment", lambda at: _unload(at, SupportPhase.LEFT)
    ),
    "torso_tilt": MotionKind("the torso tilted forward, back, left and right", _tilt),
    "torso_height": MotionKind("landmark to landmark with the torso lower", _height),
}
