"""Distance of capsules: all points within a radius of a segment (paper, section IV, fig. 3c).

The distance of two capsules is that of their segments less both radii; negative where they
overlap. It stands here twice: in numpy, exact, to check with, and as an expression, smoothed a
little, to optimise with.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from shoecal_core.arrays import FloatArray

_TINY = 1e-14
"""m^2; squared lengths below this are those of points."""
_PARALLEL = 1e-10
"""Squared sine of the angle below which two segments count as parallel."""
SOFTNESS = 1e-5
"""Pull of the nearest points towards the segments' middles, over the mean squared length."""


def segment_distance(
    start_a: FloatArray, end_a: FloatArray, start_b: FloatArray, end_b: FloatArray
) -> FloatArray:
    """Distance between segments, exact also for parallel ones and for points.

    All ends are (..., 3) [m]; the distances are (...) [m].
    """
    nearest = np.minimum.reduce(
        [
            _point_segment(start_a, start_b, end_b),
            _point_segment(end_a, start_b, end_b),
            _point_segment(start_b, start_a, end_a),
            _point_segment(end_b, start_a, end_a),
        ]
    )
    return np.minimum(nearest, _inner_distance(start_a, end_a, start_b, end_b))


def segment_distance_squared(start_a: ca.SX, end_a: ca.SX, start_b: ca.SX, end_b: ca.SX) -> ca.SX:
    """Squared distance between two segments, (3, 1) points, as a smooth expression [m^2].

    The distance of parallel segments does not show which points are nearest, and those of nearly
    parallel ones jump from end to end: the distance then has a kink, and derivatives without
    bound. So what is minimised over the places s, t on the segments is

        |gap(s, t)|^2 + soft ((s - 1/2)^2 + (t - 1/2)^2 - 1/2),   soft = SOFTNESS * mean length^2

    which has one minimum, a continuous gradient, and is never more than the squared distance; it
    is less by no more than soft / 2. For a clamped convex quadratic in two variables the minimum
    is s, then t, then s again, each clamped (C. Ericson, Real-Time Collision Detection, 5.1.9).
    """
    way_a, way_b, between = end_a - start_a, end_b - start_b, start_a - start_b
    a, b, e = ca.dot(way_a, way_a), ca.dot(way_a, way_b), ca.dot(way_b, way_b)
    soft = SOFTNESS * (a + e) / 2.0 + _TINY
    a, e = a + soft, e + soft
    c, f = ca.dot(way_a, between) - soft / 2.0, ca.dot(way_b, between) + soft / 2.0
    s = _clamp((b * f - c * e) / (a * e - b * b))
    t = _clamp((b * s + f) / e)
    s = _clamp((b * t - c) / a)
    gap = between + s * way_a - t * way_b
    return ca.dot(gap, gap) + soft * ((s - 0.5) ** 2 + (t - 0.5) ** 2 - 0.5)


def _clamp(value: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(value, 0.0), 1.0)


def _point_segment(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    way = end - start
    length = np.maximum(np.sum(way * way, axis=-1), _TINY)
    part = np.clip(np.sum((point - start) * way, axis=-1) / length, 0.0, 1.0)
    distance: FloatArray = np.linalg.norm(point - start - part[..., None] * way, axis=-1)
    return distance


def _inner_distance(
    start_a: FloatArray, end_a: FloatArray, start_b: FloatArray, end_b: FloatArray
) -> FloatArray:
    """Distance of the two lines where they are nearest inside both segments, else infinite."""
    way_a, way_b, between = end_a - start_a, end_b - start_b, start_a - start_b
    a, b, e = (np.sum(x * y, axis=-1) for x, y in ((way_a, way_a), (way_a, way_b), (way_b, way_b)))
    c, f = (np.sum(way * between, axis=-1) for way in (way_a, way_b))
    denominator = a * e - b * b
    crossing = denominator > _PARALLEL * a * e
    safe = np.where(crossing, denominator, 1.0)
    s, t = (b * f - c * e) / safe, (a * f - b * c) / safe
    inside = crossing & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    gap = np.linalg.norm(between + s[..., None] * way_a - t[..., None] * way_b, axis=-1)
    return np.where(inside, gap, np.inf)
