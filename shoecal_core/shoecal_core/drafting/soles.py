"""Soles of feet: the face on which a foot stands when it is loaded through its ankle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import shapely
from scipy.spatial import ConvexHull, QhullError
from shapely.geometry.base import BaseGeometry

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import UP
from shoecal_core.robot.urdf import UrdfError

TOUCHING = 0.002
"""m; what is no farther from the sole's plane belongs to the sole."""
LEVEL = np.radians(2.0)
"""A face that is off level by less than this in the zero pose is level."""
STEEPEST = np.radians(40.0)
CORNERS = 12
"""Most corners of an outline."""
LEAST_AREA = 2e-4
"""m^2; less than this is an edge or a point."""


@dataclass(frozen=True)
class SoleSize:
    """A rectangular sole as somebody measured it: its edges from the ankle's axes [m].

    Attributes:
        back, front: behind and before the ankle.
        inner, outer: towards the other foot and away from it.
        height: of the ankle above the floor.
    """

    back: float
    front: float
    inner: float
    outer: float
    height: float


@dataclass(frozen=True)
class Sole:
    """One sole.

    Attributes:
        link: the leg's last link.
        placement: the sole frame in that link: below the ankle, x forward, z up.
        outline: (k, 2) convex, counter-clockwise, sole frame [m].
        in_base: the sole frame in the base, in the zero pose.
        height: of the ankle joint above it [m].
    """

    link: str
    placement: pin.SE3
    outline: FloatArray
    in_base: pin.SE3
    height: float


def find_sole(body: Body, joint: int, points: FloatArray, forward: FloatArray) -> Sole:
    """The sole of the foot that a leg's last joint turns.

    Args:
        body: in its zero pose.
        joint: the leg's last.
        points: (k, 3) corners of the foot's shapes in that joint's frame [m].
        forward: (3,) unit vector in the base frame.

    Raises:
        UrdfError: for a foot without shapes, or without a face to stand on.
    """
    link, _ = body.link(joint)
    if len(points) < 4:
        raise UrdfError(
            body.urdf,
            "has no <collision> or <visual> shape, so its sole is not known; add one (a box of "
            "the sole's size is enough), or measure the sole and give --sole",
            field=f"link {link}",
        )
    placement = body.placements[joint]
    seen = np.array([placement.act(point) for point in points])
    ankle = body.centres[joint]
    normal = _standing_normal(body, link, seen, ankle)
    ground = float((seen @ normal).min())
    touching = seen[seen @ normal < ground + TOUCHING]
    height = float(ankle @ normal) - ground
    in_base = _below(ankle, height, normal, forward)
    flat = np.array([in_base.actInv(point)[:2] for point in touching])
    outline = shapely.MultiPoint(flat).convex_hull
    if not isinstance(outline, shapely.Polygon) or outline.area < LEAST_AREA:
        raise UrdfError(
            body.urdf,
            "its lowest shapes touch the floor in a point or an edge, not in a face; give the "
            "foot a <collision> box of the sole's size",
            field=f"link {link}",
        )
    return _sole(body, joint, simplified(outline), in_base, height)


def measured_sole(
    body: Body, joint: int, size: SoleSize, forward: FloatArray, *, is_left: bool
) -> Sole:
    """The sole of a given size, level in the zero pose.

    Args:
        body: in its zero pose.
        joint: the leg's last.
        size: of either foot.
        forward: (3,) unit vector in the base frame.
        is_left: the left foot's inner edge is on its right.
    """
    right, left = (size.inner, size.outer) if is_left else (size.outer, size.inner)
    corners = shapely.box(-size.back, -right, size.front, left)
    in_base = _below(body.centres[joint], size.height, UP, forward)
    return _sole(body, joint, simplified(corners), in_base, size.height)


def _below(ankle: FloatArray, height: float, normal: FloatArray, forward: FloatArray) -> pin.SE3:
    """The sole frame in the base: below the ankle, x forward, z along the normal."""
    ahead = forward - (forward @ normal) * normal
    ahead /= np.linalg.norm(ahead)
    axes = np.column_stack([ahead, np.cross(normal, ahead), normal])
    return pin.SE3(axes, ankle - height * normal)


def _sole(body: Body, joint: int, outline: FloatArray, in_base: pin.SE3, height: float) -> Sole:
    link, frame = body.link(joint)
    placement = (body.placements[joint] * frame).actInv(in_base)
    return Sole(link, placement, outline, in_base, height)


def simplified(polygon: BaseGeometry) -> FloatArray:
    """(k, 2) corners of a convex polygon [m], few of them, to tenths of a millimetre."""
    step = 2e-4
    coords = shapely.get_coordinates(polygon)
    while len(coords) - 1 > CORNERS:
        coords = shapely.get_coordinates(shapely.simplify(shapely.Polygon(coords), step))
        step *= 1.5
    rounded = np.round(coords, 4)
    return np.asarray(rounded[ConvexHull(rounded).vertices])


def _standing_normal(body: Body, link: str, seen: FloatArray, ankle: FloatArray) -> FloatArray:
    """Upward normal of the face that the vertical through the ankle leaves the foot by."""
    try:
        hull = ConvexHull(seen)
    except QhullError as error:
        if (flat := _normal_of_plane(seen)) is not None:
            return flat
        raise UrdfError(
            body.urdf,
            "its shapes have no volume, so no sole is known; add a <collision> box of the sole's "
            "size",
            field=f"link {link}",
        ) from error
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    downward = -(normals @ UP)
    facing = downward > np.cos(STEEPEST)
    if not facing.any():
        raise UrdfError(
            body.urdf,
            f"no face of its shapes is within {np.degrees(STEEPEST):.0f} degrees of level in the "
            "zero pose; give the foot a <collision> box of the sole's size",
            field=f"link {link}",
        )
    # An exporter may put the ankle off the foot: then by the foot's middle.
    outline = shapely.MultiPoint(seen[:, :2]).convex_hull
    inside = outline.contains(shapely.Point(ankle[:2]))
    start = ankle if inside else np.array([*outline.centroid.coords[0], ankle[2]])
    way = -(normals @ start + offsets)[facing] / downward[facing]
    return _levelled(-normals[facing][np.argmin(way)])


def _normal_of_plane(seen: FloatArray) -> FloatArray | None:
    """Upward normal of points that lie in one plane to stand on: contact points, say."""
    _, sizes, rows = np.linalg.svd(seen - seen.mean(axis=0), full_matrices=False)
    normal = rows[2] * np.sign(rows[2] @ UP)
    if sizes[1] < TOUCHING or not normal @ UP > np.cos(STEEPEST):
        return None
    return _levelled(normal)


def _levelled(normal: FloatArray) -> FloatArray:
    """The vertical, for a face that is all but level."""
    return UP if normal @ UP > np.cos(LEVEL) else np.asarray(normal)
