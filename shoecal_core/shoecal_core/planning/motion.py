"""From planned states to a joint trajectory: at rest, slowly there, at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.rolling import Path
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.segment import MotionSegment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.supports.observability import PLACES, Visit
from shoecal_core.planning.timing import GRID, Profile, Rates, fastest
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY


@dataclass(frozen=True)
class Phase:
    """A span of a motion, from rest to rest.

    Attributes:
        name: of the segment that was followed.
        support_phase: which feet stand.
        begin, end: since the motion's begin [s].
        foot_poses: of the right sole in the left sole's frame, at start and end.
        pace: factor on all speeds.
        loaded: whether left, right have to keep load and grip.
    """

    name: str
    support_phase: SupportPhase
    begin: float
    end: float
    foot_poses: tuple[FootPose, FootPose]
    pace: float = 1.0
    loaded: tuple[bool, bool] = (True, True)


@dataclass(frozen=True)
class Motion:
    """A whole-body motion from standing still to standing still on both feet.

    Attributes:
        name: in the motion catalogue, for example `landmarks`.
        support: where it begins.
        foot_pose: the pose between the soles there, by the joint angles.
        joint_names: m joints.
        time: (T,) from zero [s].
        positions: (T, m) [rad].
        velocities: (T, m) [rad/s].
        cop: (T, 2) planned CoP in the left sole's frame [m].
        path: the planned states behind it.
        phases: one after another, without gaps.
    """

    name: str
    support: DoubleSupport
    foot_pose: FootPose
    joint_names: tuple[str, ...]
    time: FloatArray
    positions: FloatArray
    velocities: FloatArray
    cop: FloatArray
    path: Path
    phases: tuple[Phase, ...]

    @property
    def duration(self) -> float:
        """From the first to the last point [s]."""
        return float(self.time[-1])

    @property
    def visit(self) -> Visit:
        """What its CoP does, for what it would identify."""
        every = max(1, len(self.cop) // PLACES)
        return Visit(self.support, self.cop[::every], self.duration)


def com_acceleration_limit(height: float, settings: PlannerSettings) -> float:
    """Acceleration of a CoM at a height [m] that shifts the CoP by dynamic_cop_error [m/s^2].

    A point mass accelerated by a has its CoP at c - z a / g.
    """
    return settings.dynamic_cop_error * GRAVITY / height


def timed(
    legs: Legs,
    parts: Sequence[tuple[MotionSegment, Path]],
    name: str,
    others: FloatArray,
    settings: PlannerSettings,
) -> Motion:
    """Follow planned states as fast as the settings allow, at rest between the parts.

    Args:
        legs: of the robot.
        parts: what was planned, one after another.
        name: of the motion.
        others: (m,) all joint angles, of which those outside the legs count [rad].
        settings: speeds, accelerations, hold time and sample rate.
    """
    robot = legs.robot
    ways = [_way(legs, segment, path, others, settings) for segment, path in parts]
    # Whole samples, so that at the borders of parts there is one at rest.
    hold = math.ceil(settings.hold_time * settings.sample_rate)
    begins = [hold]
    for (segment, _), way in zip(parts, ways, strict=True):
        seconds = float(way.profile.times[-1]) + segment.pause
        begins.append(begins[-1] + math.ceil(seconds * settings.sample_rate))
    time = np.arange(begins.pop() + hold + 1) / settings.sample_rate
    leg_angles = np.zeros((len(time), len(robot.legs)))
    leg_rates = np.zeros_like(leg_angles)
    for begin, way in zip(begins, ways, strict=True):
        since = slice(begin if begin > hold else 0, None)
        leg_angles[since], leg_rates[since] = way.at(time[since] - time[begin])
    still = np.zeros(len(robot.joint_names))
    positions = robot.from_legs(leg_angles, others)
    first = parts[0][0].pose(0)
    return Motion(
        name=name,
        support=first.support,
        foot_pose=first,
        joint_names=robot.joint_names,
        time=time,
        positions=positions,
        velocities=robot.from_legs(leg_rates, still),
        cop=legs.cop(positions),
        path=Path.joined([path for _, path in parts]),
        phases=_phases([segment for segment, _ in parts], time[begins[1:]], float(time[-1])),
    )


@dataclass(frozen=True)
class _Way:
    """Leg angles as a function of s, and s as one of time."""

    spline: CubicSpline
    profile: Profile

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(T, k) angles [rad] and rates [rad/s]; at rest before and after."""
        s, rate = self.profile.at(time)
        return self.spline(s), self.spline(s, 1) * rate[:, None]


def _way(
    legs: Legs, segment: MotionSegment, path: Path, others: FloatArray, settings: PlannerSettings
) -> _Way:
    settings, robot = settings.paced(segment.pace), legs.robot
    # A robot that never moves stays for one step.
    states = path.states if len(path.states) > 1 else np.repeat(path.states, 2, axis=0)
    count = len(states) - 1
    spline = CubicSpline(np.arange(count + 1), states)
    grid = np.linspace(0.0, count, GRID * count + 1)
    # Speeds are those over the floor, so seen from a foot that stands on it.
    com = legs.kinematics.states(robot.from_legs(spline(grid), others)).com
    com = com[:, segment.support_phase.standing]
    rates = Rates(
        joint_speed=np.minimum(robot.velocity_limit[robot.legs], settings.joint_speed),
        joint_acceleration=np.full(len(robot.legs), settings.joint_acceleration),
        com_speed=settings.com_speed,
        com_acceleration=com_acceleration_limit(float(com[:, 2].max()), settings),
        state_rate=1.0 / settings.step_time,
    )
    return _Way(spline, fastest(spline, com[:, :2], grid, rates))


def _phases(segments: Sequence[MotionSegment], inner: FloatArray, end: float) -> tuple[Phase, ...]:
    borders = [0.0, *inner.tolist(), end]
    return tuple(
        Phase(
            segment.name,
            segment.support_phase,
            begin,
            until,
            (segment.pose(0), segment.foot_poses[-1]),
            segment.pace,
            segment.loaded,
        )
        for segment, begin, until in zip(segments, borders[:-1], borders[1:], strict=True)
    )
