"""The double support of a bag in which the feet stand still, by its joint angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.recording.bag import Bag
from shoecal_core.recording.bag_fields import table
from shoecal_core.recording.bag_match import Match
from shoecal_core.recording.limits import in_degrees
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointsMissingError, Robot

SAMPLES = 200
"""Joint angles of a bag that are looked at, evenly over its messages."""
STILL_M = 0.01
"""Feet whose distance changes by less stand still."""


def standing_support(
    bag: Bag, joints: Match, robot: Robot, span: tuple[float, float] | None
) -> DoubleSupport | None:
    """Where the right sole is in the left one's frame, by forward kinematics.

    Args:
        bag: open.
        joints: the topics of its joint angles.
        robot: with its shoes on.
        span: part of the bag since its first message [s]; None: all of it.

    Returns:
        None where the feet move against each other, or where no message has all joints.
    """
    names, measured = _measured(bag, joints, robot, span)
    if _degrees(names, measured, robot):
        measured = np.radians(measured)
    try:
        angles = robot.from_measured(names, measured)
    except JointsMissingError:
        return None
    states = Kinematics(robot).states(angles[np.isfinite(angles).all(axis=1)])
    places = states.translation[:, :2]
    if not len(places) or np.ptp(places, axis=0).max() > STILL_M:
        return None
    return states.support()


def angles_in_degrees(bag: Bag, joints: Match, robot: Robot) -> bool:
    """Whether a bag's joint angles are beyond the robot's limits, but within them as degrees."""
    return _degrees(*_measured(bag, joints, robot, None), robot)


def _degrees(names: Sequence[str], measured: NDArray[np.float64], robot: Robot) -> bool:
    for name, angles in zip(names, measured.T, strict=True):
        joint, there = robot.joint(name), angles[np.isfinite(angles)]
        if len(there) and in_degrees(there, robot.lower[joint], robot.upper[joint]):
            return True
    return False


def _measured(
    bag: Bag, joints: Match, robot: Robot, span: tuple[float, float] | None
) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the robot's joints, and their angles (k, m) from some messages [rad]."""
    ends = (None, None) if span is None else tuple(bag.start_ns + round(1e9 * at) for at in span)
    names: list[str] = []
    rows: list[NDArray[np.float64]] = []
    for message in bag.messages(joints.topics, *ends):
        fields = joints.fields.get(message.topic)
        if fields is None:
            found = [joints.rename.get(name, name) for name in message.content.name]
            position = message.content.position
        else:
            found = list(fields.values())
            position = table([message.content], list(fields))[0]
        if len(position) != len(found):
            continue
        if len(found) > len(names):
            names, rows = found, []
        if found == names:
            rows.append(position)
    if not rows:
        return [], np.zeros((0, 0))
    chosen = np.unique(np.linspace(0, len(rows) - 1, SAMPLES).astype(np.int64))
    own = [place for place, name in enumerate(names) if name in robot.joint_names]
    measured = np.array([rows[place] for place in chosen], dtype=np.float64)[:, own]
    return [names[place] for place in own], measured
