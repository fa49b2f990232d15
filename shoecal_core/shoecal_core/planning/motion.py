"""From planned states to a joint trajectory: at rest, slowly there, at rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import GRAVITY
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.rolling import Path
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.timing import GRID, Rates, fastest

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """A whole-body motion in one double support, from standing still to standing still.

    Attributes:
        name: on the menu of motions, for example `landmarks`.
        support: where it takes place.
        foot_pose: the pose between the soles that it keeps, as the joint angles tell it.
        joint_names: m joints.
        time: (T,) from zero [s].
        positions: (T, m) [rad].
        velocities: (T, m) [rad/s].
        cop: (T, 2) planned CoP in the left sole's frame [m].
        path: the planned states behind it.
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

    @property
    def duration(self) -> float:
        """From the first to the last point [s]."""
        return float(self.time[-1])


def com_acceleration_limit(height: float, settings: PlannerSettings) -> float:
    """Acceleration of a CoM at a height [m] that shifts the CoP by dynamic_cop_error [m/s^2].

    A point mass accelerated by a has its CoP at c - z a / g.
    """
    return settings.dynamic_cop_error * GRAVITY / height


def timed(
    legs: Legs,
    path: Path,
    name: str,
    foot_pose: FootPose,
    others: FloatArray,
    settings: PlannerSettings,
) -> Motion:
    """Follow planned states as fast as the settings allow, with holds at both ends.

    Args:
        legs: of the robot.
        path: planned states.
        name: of the motion.
        foot_pose: that the states keep.
        others: (m,) all joint angles, of which those beside the legs count [rad].
        settings: speeds, accelerations, hold time and sample rate.
    """
    robot = legs.robot
    # Whoever never moves stays for one step.
    states = path.states if len(path.states) > 1 else np.repeat(path.states, 2, axis=0)
    count = len(states) - 1
    spline = CubicSpline(np.arange(count + 1), states)
    grid = np.linspace(0.0, count, GRID * count + 1)
    com = legs.kinematics.states(robot.from_legs(spline(grid), others)).com[:, 0]
    rates = Rates(
        joint_speed=np.minimum(robot.velocity_limit[robot.legs], settings.joint_speed),
        joint_acceleration=np.full(len(robot.legs), settings.joint_acceleration),
        com_speed=settings.com_speed,
        com_acceleration=com_acceleration_limit(float(com[:, 2].max()), settings),
        state_rate=1.0 / settings.step_time,
    )
    profile = fastest(spline, com[:, :2], grid, rates)
    moving = profile.times[-1]
    samples = int(np.ceil((moving + 2.0 * settings.hold_time) * settings.sample_rate))
    time = np.arange(samples + 1) / settings.sample_rate
    s, rate = profile.at(time - settings.hold_time)
    positions = robot.from_legs(spline(s), others)
    still = np.zeros(len(robot.joint_names))
    velocities = robot.from_legs(spline(s, 1) * rate[:, None], still)
    return Motion(
        name=name,
        support=foot_pose.support,
        foot_pose=foot_pose,
        joint_names=robot.joint_names,
        time=time,
        positions=positions,
        velocities=velocities,
        cop=legs.cop(positions),
        path=path,
    )
