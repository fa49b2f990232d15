"""What the planner's worker process does."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.rolling import PlanningError
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import PUT_DOWN, motion_kind
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.segment import cop_segment
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper
from shoecal_core.planning.swing import stance_foot
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Link


@dataclass(frozen=True)
class Chunk:
    """A part of a streamed motion, from rest to rest.

    Attributes:
        motion: the part; None where nothing leads nearer to what was left to pursue.
        targets: (L, 2) what is left to pursue after it, left sole's frame [m].
        left: how many targets it has left behind.
        nearest: (left,) how near the CoP came to those [m].
    """

    motion: Motion | None
    targets: FloatArray
    left: int
    nearest: FloatArray


def prepare(link: Link, files: RobotFiles, settings: PlannerSettings) -> None:
    """Write the planning problem out now, so that the first motion need not wait for it."""
    del link
    _planner(files, settings)


def plan(
    link: Link,
    files: RobotFiles,
    settings: PlannerSettings,
    joint_angles: FloatArray,
    motion: str,
) -> Motion:
    """A whole motion from measured joint angles (m,) [rad], checked."""
    return _planner(files, settings).plan_from(
        joint_angles, motion, progress=link.progress, canceled=link.canceled
    )


def plan_chunk(
    link: Link,
    files: RobotFiles,
    settings: PlannerSettings,
    joint_angles: FloatArray,
    motion: str,
    targets: FloatArray | None,
    states: int,
) -> Chunk:
    """The next part of a motion from measured joint angles (m,) [rad], checked.

    Args:
        link: to the node.
        files: robot and shoe.
        settings: of planning.
        joint_angles: measured, the robot stands on both feet.
        motion: in the motion catalogue, one that streams.
        targets: (L, 2) still to pursue; None: the motion begins.
        states: most planned states of the part.
    """
    # The chunks follow each other: only the whole motion begins and ends with a hold.
    planner = _planner(files, dataclasses.replace(settings, steps_max=states, hold_time=0.0))
    standing = planner.standing(joint_angles)
    (segment,) = motion_kind(motion).segments(standing)
    if targets is not None:
        segment = cop_segment(motion, targets, standing.foot_pose, settings, pace=segment.pace)
    try:
        part = planner.follow(
            joint_angles, motion, (segment,), progress=link.progress, canceled=link.canceled
        )
    except PlanningError:
        if targets is None:
            raise
        # A whole motion also ends well where the last targets cannot be come nearer to.
        away = np.linalg.norm(targets - standing.cop, axis=1)
        return Chunk(None, targets[:0], len(targets), away)
    left = len(part.path.switches)
    return Chunk(part, segment.left_targets[left:], left, part.path.nearest[:left])


def step(
    link: Link,
    files: RobotFiles,
    settings: PlannerSettings,
    joint_angles: FloatArray,
    support: DoubleSupport,
) -> Motion | None:
    """The next own step to a double support from measured joint angles (m,) [rad], checked.

    None when the feet stand there. A robot that was stopped on one foot puts the other one down
    first.
    """
    stepper = _stepper(files, settings)
    _, height = stance_foot(stepper.planner.legs.foot_pose(joint_angles))
    if height > settings.sole_height:
        return plan(link, files, settings, joint_angles, PUT_DOWN)
    return stepper.step(joint_angles, support, progress=link.progress, canceled=link.canceled)


@cache
def _stepper(files: RobotFiles, settings: PlannerSettings) -> Stepper:
    return Stepper(_planner(files, settings))


@cache
def _planner(files: RobotFiles, settings: PlannerSettings) -> Planner:
    return Planner(files.load_robot(), settings)
