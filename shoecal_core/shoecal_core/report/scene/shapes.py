"""What a picture in three dimensions consists of: convex shapes, and what shows forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError

FloatArray = NDArray[np.float64]
Rgba = tuple[float, float, float, float]

ROUND = 20
"""Corners of what shall look round."""


@dataclass(frozen=True)
class LinkShape:
    """All points within `radius` of the convex hull of some points.

    One point makes a ball, two make a capsule; more must span a volume where the radius is 0.

    Attributes:
        points: (k, 3) in the world, z up [m].
        radius: [m].
        rgba: colour, each 0 to 1.
    """

    points: FloatArray
    radius: float
    rgba: Rgba

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not len(self.points):
            raise ShapeError("points of a shape", "(k, 3)", self.points.shape)


def prism(outline: FloatArray, low: float, high: float) -> FloatArray:
    """Corners (2k, 3) over an outline (k, 2), between two heights [m]."""
    return np.vstack([np.column_stack((outline, np.full(len(outline), z))) for z in (low, high)])


def disc(centre: FloatArray, radius: float) -> FloatArray:
    """Corners (ROUND, 2) of a circle about a place (2,) [m]."""
    angle = np.linspace(0.0, 2.0 * math.pi, ROUND, endpoint=False)
    return centre + radius * np.column_stack((np.cos(angle), np.sin(angle)))


def arrow(foot: FloatArray, height: float, radius: float, rgba: Rgba) -> tuple[LinkShape, ...]:
    """An arrow that points upwards from a place (3,), for a force [m]."""
    head = min(6.0 * radius, height)
    neck, top = (foot + lift * np.array([0.0, 0.0, 1.0]) for lift in (height - head, height))
    ring = np.column_stack((disc(foot[:2], 2.4 * radius), np.full(ROUND, neck[2])))
    tip = np.vstack((ring, top))
    return LinkShape(np.vstack((foot, neck)), radius, rgba), LinkShape(tip, 0.0, rgba)


def path(places: FloatArray, radius: float, rgba: Rgba) -> tuple[LinkShape, ...]:
    """A line through places (k, 3) [m]; where one is not known it is broken.

    Steps that cannot be seen are left out.
    """
    kept: list[FloatArray] = []
    shapes = []
    for place in places:
        if kept and np.linalg.norm(place - kept[-1]) < 0.5 * radius:
            continue
        if kept and np.isfinite((place, kept[-1])).all():
            shapes.append(LinkShape(np.vstack((kept[-1], place)), radius, rgba))
        kept.append(place)
    return tuple(shapes)


def dashes(low: FloatArray, high: FloatArray, radius: float, rgba: Rgba) -> tuple[LinkShape, ...]:
    """A dashed line from one place (3,) to another [m]."""
    length = float(np.linalg.norm(high - low))
    count = max(1, round(length / (8.0 * radius)))
    starts = (np.arange(count) + 0.25) / count
    return tuple(
        LinkShape(np.vstack([low + part * (high - low) for part in (start, start + 0.5 / count)]),
              radius, rgba)
        for start in starts
    )  # fmt: skip


def gathered(parts: Sequence[Sequence[LinkShape]]) -> tuple[LinkShape, ...]:
    """Shapes of several things as one sequence."""
    return tuple(shape for part in parts for shape in part)
