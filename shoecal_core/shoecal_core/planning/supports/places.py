"""Places over a sensing polygon."""

from __future__ import annotations

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray

SPACING = 0.01
"""m between neighbouring places."""


def places_over(polygon: FloatArray) -> FloatArray:
    """(p, 2) corners of a convex polygon (k, 2) and a grid inside it [m]."""
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    axes = [np.arange(start, end, SPACING) for start, end in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = shapely.contains_xy(shapely.Polygon(polygon), grid[:, 0], grid[:, 1])
    return np.concatenate((polygon, grid[inside]))
