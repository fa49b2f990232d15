"""The body along a planned motion, in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.motion import Skeleton, skeleton
from shoecal_core.report.plan_content import PlannedMotion

FloatArray = NDArray[np.float64]


def moved(planned: PlannedMotion, sample: int) -> Skeleton:
    """The body in the world, from where the foot that carries stands."""
    stance = int(planned.stance[sample])
    body = skeleton(planned.robot, planned.motion.positions[sample], stance)
    turns, places = planned.soles
    turn, place = turns[sample, stance], places[sample, stance]

    def there(points: FloatArray) -> FloatArray:
        """(k, 3) points in the world [m]."""
        placed: FloatArray = points @ turn.T + place
        return placed

    return Skeleton(
        there(body.bones), body.side, (there(body.soles[0]), there(body.soles[1])),
        there(body.capsules), there(body.com),
    )  # fmt: skip


def polygons(planned: PlannedMotion, sample: int) -> tuple[FloatArray, FloatArray]:
    """Corners (c, 3) of each foot's sensing polygon at a sample, in the world [m]."""
    turns, places = planned.soles
    left, right = (
        np.column_stack((foot.sensing_polygon, np.zeros(len(foot.sensing_polygon))))
        @ turns[sample, side].T
        + places[sample, side]
        for side, foot in enumerate(planned.robot.feet)
    )
    return left, right
