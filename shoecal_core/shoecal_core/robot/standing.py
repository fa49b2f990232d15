"""How a robot's feet stand on the floor, and whether what a robot file says of it can be."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import shapely

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET

MAX_LEAN = np.radians(60.0)
"""A CoM farther off a sole's z axis than this is not above that sole: the axis points elsewhere."""

OPPOSITE = np.radians(120.0)
"""No posture turns one foot farther from the other: one sole's x axis points to the heel."""


def feet_gap(robot: Robot, support: DoubleSupport) -> float:
    """Gap between the outlines of the two feet, zero where they touch or overlap [m]."""
    left, right = (foot.outline for foot in robot.feet)
    gap = shapely.Polygon(left).distance(shapely.Polygon(support.right_to_left(right)))
    return float(gap)


def check_standing(robot: Robot, fields: Fields) -> None:
    """Refuse a robot file whose neutral double support or posture cannot be stood in.

    Raises:
        FileError: for overlapping feet, and for soles that do not face the floor.
    """
    neutral = robot.neutral
    if not feet_gap(robot, neutral) > 0.0:
        raise fields.mapping("support_range").error(
            "dy_m.neutral",
            f"the outlines of the feet overlap at {neutral}; move the right foot farther to the "
            "right (dy is negative there), or correct feet.*.outline_m",
        )
    (left, right), com = _in_posture(robot)
    for name, sole in zip(FEET, (left, right), strict=True):
        _check_upright(sole.actInv(com), fields.mapping("feet").mapping(name))
    between = left.actInv(right)
    yaw = np.arctan2(between.rotation[1, 0], between.rotation[0, 0])
    if abs(yaw) > OPPOSITE:
        left_ahead, right_ahead = (
            np.degrees(np.arctan2(sole.rotation[1, 0], sole.rotation[0, 0]))
            for sole in (left, right)
        )
        raise fields.error(
            "feet",
            "in posture_rad the x axes of the soles point apart (left at "
            f"{left_ahead:.0f}, right at {right_ahead:.0f} degrees from the base's x axis); turn "
            "the sole_rpy_rad of the foot whose x axis points to its heel by half a turn about z",
        )
    if between.translation[1] > 0.0 > neutral.dy:
        raise fields.error(
            "feet", "left and right are exchanged: the right sole lies to the left of the left one"
        )
    stance = DoubleSupport(*(float(value) for value in (*between.translation[:2], yaw)))
    if not feet_gap(robot, stance) > 0.0:
        raise fields.error(
            "posture_rad",
            "the outlines of the feet overlap in this posture; move the legs apart, or correct "
            "feet.*.outline_m",
        )


def _check_upright(com: FloatArray, foot: Fields) -> None:
    """The CoM (3,) in a sole's frame must be above it [m]."""
    lean = np.arctan2(np.hypot(com[0], com[1]), com[2])
    if lean > MAX_LEAN:
        raise foot.error(
            "sole_rpy_rad",
            f"in posture_rad the CoM is {np.degrees(lean):.0f} degrees off this sole's z axis; "
            "turn the sole frame so that z points up, or correct the posture",
        )


def _in_posture(robot: Robot) -> tuple[tuple[pin.SE3, pin.SE3], FloatArray]:
    """Sole frames and CoM (3,) in the base's frame, in the robot's own posture."""
    data = robot.model.createData()
    base = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    com: FloatArray = pin.centerOfMass(robot.model, data, np.concatenate([base, robot.posture]))
    pin.updateFramePlacements(robot.model, data)
    left, right = (pin.SE3(data.oMf[foot.frame]) for foot in robot.feet)
    return (left, right), com
