"""The feet of a robot as figures show them."""

from __future__ import annotations

import numpy as np

from shoecal_core.report.figures.plane import FootShape
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe


def foot_shape(
    robot: Robot, shoe: Shoe, foot: int, support: DoubleSupport | None = None
) -> FootShape:
    """One foot with its cells.

    Args:
        robot, shoe: whose foot.
        foot: index into FEET.
        support: where the right foot stands, for a shape in the left sole's frame; None: in the
            foot's own.
    """
    shape = robot.feet[foot]
    cells = np.unique(shoe.positions[shoe.of_foot(foot)], axis=0)
    places = (shape.outline, shape.sensing_polygon, cells)
    outline, polygon, cells = (
        places if support is None else (support.right_to_left(points) for points in places)
    )
    return FootShape(FEET[foot], outline, polygon, cells)
