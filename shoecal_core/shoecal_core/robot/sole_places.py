"""Soles that a robot file puts elsewhere than the URDF puts the feet's shapes."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.robot.link_shapes import Description, find_shapes
from shoecal_core.robot.robot import Foot, Robot
from shoecal_core.shoe.shoe import FEET

NEAR = 0.005
"""m; what of a foot is no higher above its lowest point is near the floor: soles of meshes are not
even to the millimetre."""
MOST_OFF = 0.008
"""m; outlines are measured and rounded to some millimetres, and soles stand out by as much."""


@dataclass(frozen=True)
class MisplacedSole:
    """A sole off the shape of its foot.

    Attributes:
        foot: of FEET.
        offset: (2,) of the sole from the shape, sole frame [m]; 0 along an axis of no doubt.
        cure: (3,) to be added to the robot file's `sole_xyz_m` [m].
    """

    foot: str
    offset: FloatArray
    cure: FloatArray


def misplaced_soles(robot: Robot) -> list[MisplacedSole]:
    """The soles whose outline stands out of the foot's shape on one side, and in on the other.

    Outlines that are larger or smaller than the shape say nothing about their place; feet without
    shapes, or with meshes that are not there, say nothing at all.
    """
    try:
        # The model was made of it, so no entity can unfold here.
        root = ElementTree.parse(robot.urdf).getroot()  # noqa: S314
        described = Description(robot.urdf, root, robot.model, meshes=None)
        shapes = find_shapes(described, {foot.joint for foot in robot.feet})
    except (FileError, ElementTree.ParseError):
        return []
    found = []
    for side, foot in zip(FEET, robot.feet, strict=True):
        points = shapes.points[foot.joint]
        if not len(points) or shapes.missing[foot.joint]:
            continue
        offset = _off_shape(foot, points)
        if offset.any():
            joint_R_link = robot.model.frames[foot.link].placement.rotation
            in_joint = foot.placement.rotation @ np.append(-offset, 0.0)
            found.append(MisplacedSole(side, offset, joint_R_link.T @ in_joint))
    return found


def _off_shape(foot: Foot, points: FloatArray) -> FloatArray:
    """(2,) how far a sole is off its foot's corners (k, 3) in the joint's frame [m]."""
    seen = np.array([foot.placement.actInv(point) for point in points])
    low = seen[seen[:, 2] < seen[:, 2].min() + NEAR, :2]
    return off_bounds(foot.outline, low)


def off_bounds(ours: FloatArray, theirs: FloatArray) -> FloatArray:
    """(2,) how far the middle of places (n, 2) is off that of others (k, 2) along each axis, where
    they stand out of them on one side and leave them free on the other [m]; else 0.
    """
    ends = np.array([ours.max(axis=0) - theirs.max(axis=0), ours.min(axis=0) - theirs.min(axis=0)])
    one_way = (ends > MOST_OFF).all(axis=0) | (ends < -MOST_OFF).all(axis=0)
    return np.where(one_way, ends.mean(axis=0), 0.0)
