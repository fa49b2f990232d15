"""Where the CoP shall go: landmarks, their contour and the order of pursuit (paper, IV-B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot

FROM_EDGE = 0.25
"""Part of a sensing polygon's length between a landmark and the nearest edge."""


def foot_landmarks(sensing_polygon: FloatArray) -> FloatArray:
    """(2, 2) front and rear landmark of one foot, in its sole frame [m].

    They lie on the centre line, halfway between the polygon's left and right border.
    """
    rear, front = sensing_polygon[:, 0].min(), sensing_polygon[:, 0].max()
    length = front - rear
    at = (front - FROM_EDGE * length, rear + FROM_EDGE * length)
    return np.array([[x, _halfway(sensing_polygon, x)] for x in at])


def _halfway(polygon: FloatArray, x: float) -> float:
    reach = np.abs(polygon).max() + 1.0
    across = shapely.LineString([(x, -reach), (x, reach)])
    _, right, _, left = shapely.Polygon(polygon).intersection(across).bounds
    return float(right + left) / 2.0


def sensing_hull(robot: Robot, support: DoubleSupport) -> shapely.Polygon:
    """Sensing polygon of a double support: the hull of both feet's, left sole's frame [m]."""
    left, right = (foot.sensing_polygon for foot in robot.feet)
    points = np.vstack([left, support.right_to_left(right)])
    hull = shapely.MultiPoint(points).convex_hull
    assert isinstance(hull, shapely.Polygon)
    return hull


@dataclass(frozen=True)
class Contour:
    """The closed contour of the landmarks of a double support.

    Attributes:
        corners: (4, 2) landmarks, counter-clockwise, left sole's frame [m].
    """

    corners: FloatArray

    @classmethod
    def of(cls, robot: Robot, support: DoubleSupport) -> Contour:
        """Two landmarks a foot, joined around their centre."""
        left, right = (foot_landmarks(foot.sensing_polygon) for foot in robot.feet)
        points = np.vstack([left, support.right_to_left(right)])
        x, y = (points - points.mean(axis=0)).T
        return cls(points[np.argsort(np.arctan2(y, x))])

    @property
    def midpoints(self) -> FloatArray:
        """(4, 2) middles of the sides; side i runs from corner i to the next one [m]."""
        following = np.roll(self.corners, -1, axis=0)
        middles: FloatArray = (self.corners + following) / 2.0
        return middles

    def targets(self, cop: FloatArray) -> FloatArray:
        """(5, 2) places to pursue from an initial CoP (2,), left sole's frame [m].

        First the side's midpoint nearest to it, then the landmarks counter-clockwise,
        beginning with the end of that side.
        """
        midpoints = self.midpoints
        side = int(np.argmin(np.linalg.norm(midpoints - cop, axis=1)))
        return np.vstack([midpoints[side], np.roll(self.corners, -(side + 1), axis=0)])

    def reversed_targets(self, cop: FloatArray) -> FloatArray:
        """(5, 2) as `targets` [m], but clockwise, beginning with the start of that side."""
        forward = self.targets(cop)
        return np.vstack([forward[:1], forward[:0:-1]])
