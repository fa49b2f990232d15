"""Robot, feet, cells, forces and centres as markers, for RViz and Foxglove.

| namespace         | what                                                    | frame              |
|-------------------|---------------------------------------------------------|--------------------|
| `body`            | limbs as thick as their mass requires, feet, shoes      | `l_sole`           |
| `sole`            | outlines of the soles                                   | `l_sole`, `r_sole` |
| `sensing_polygon` | where the CoP of each foot may be                       | `l_sole`, `r_sole` |
| `support_polygon` | hull of both sensing polygons while both feet carry     | `l_sole`           |
| `cells`           | cells, red where their status is not good               | `l_sole`, `r_sole` |
| `force`           | measured force on each foot, at its CoP                 | `l_sole`, `r_sole` |
| `cop_measured`    | measured CoP of both feet                               | `l_sole`, `r_sole` |
| `cop_modelled`    | ground projection of the CoM                            | `l_sole`           |
| `com`             | the CoM, and the line to its ground projection          | `l_sole`           |
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.model.body_shapes import CELL, Joints, LinkShape, Rgba, body_shapes, joints_at

FORCE_HEIGHT = 0.75
"""Length of the arrow for the robot's weight, over the height of its CoM."""
LIFETIME_S = 1
"""s; what is published no more vanishes, so that no viewer shows what is not."""
LINE, BALL = 0.003, 0.012
"""m: width of lines, diameter of centres."""

OUTLINE: Rgba = (0.65, 0.70, 0.75, 1.0)
POLYGON: Rgba = (0.30, 0.80, 0.65, 1.0)
MEASURED: Rgba = (0.95, 0.35, 0.15, 1.0)
MODELLED: Rgba = (0.25, 0.65, 1.0, 1.0)
COM: Rgba = (0.95, 0.85, 0.30, 1.0)
BAD: Rgba = (1.0, 0.0, 0.1, 1.0)


@dataclass(frozen=True)
class FootSeen:
    """What is measured of one foot, as far as it is known and fresh.

    Attributes:
        loaded: it carries; None where unknown.
        force: of the floor on it, upwards [N].
        cop: (2,) in its sole frame [m].
        bad: names of cells whose status is not good.
    """

    loaded: bool | None = None
    force: float | None = None
    cop: FloatArray | None = None
    bad: frozenset[str] = frozenset()


@dataclass(frozen=True)
class MeasuredInstant:
    """What is measured at about one instant.

    Attributes:
        feet: left, right.
        frame: foot in whose sole frame `cop` is.
        cop: (2,) of both feet [m].
    """

    feet: tuple[FootSeen, FootSeen] = (FootSeen(), FootSeen())
    frame: int = 0
    cop: FloatArray | None = None


class SceneMarkers:
    """Makes all markers of one robot; what never changes is worked out once."""

    def __init__(self, robot: Robot, shoe: Shoe, soles: tuple[str, str]) -> None:
        """Markers of a robot on shoes, in the frames of its soles."""
        self._robot, self._shoe, self._soles = robot, shoe, soles
        at = joints_at(robot, robot.posture)
        self._length = FORCE_HEIGHT * float(at.com[2]) / robot.weight
        # Limbs are rigid: which corners make which triangle does not change as they move.
        self._faces = [_faces(shape) for shape in body_shapes(robot, shoe, at, cells=False)]
        self._polygons = [_ring(foot.sensing_polygon) for foot in robot.feet]

    def at(self, stamp_ns: int, angles: FloatArray, seen: MeasuredInstant) -> MarkerArray:
        """Everything at joint angles (m,) [rad] and with what is measured."""
        joints = joints_at(self._robot, angles)
        markers = [
            *self._body(joints),
            *(one for foot in (0, 1) for one in self._foot(foot, seen.feet[foot])),
            *self._centres(joints, seen),
        ]
        ids: dict[str, int] = {}
        for marker in markers:
            marker.header.stamp = header_to_ros(stamp_ns).stamp
            marker.lifetime = Duration(sec=LIFETIME_S)
            marker.id = ids[marker.ns] = ids.get(marker.ns, -1) + 1
        return MarkerArray(markers=markers)

    def _body(self, at: Joints) -> Iterator[Any]:
        # Cells are markers of their own, which change their colour.
        shapes = body_shapes(self._robot, self._shoe, at, cells=False)
        for shape, faces in zip(shapes, self._faces, strict=True):
            yield from _solid(self._soles[0], shape, faces)

    def _foot(self, foot: int, seen: FootSeen) -> Iterator[Any]:
        shape = self._robot.feet[foot]
        yield _line("sole", self._soles[foot], _ring(shape.outline), OUTLINE)
        yield _line("sensing_polygon", self._soles[foot], self._polygons[foot], POLYGON)
        for index in np.flatnonzero(self._shoe.foot == foot):
            bad = self._shoe.names[index] in seen.bad
            yield _cell(self._soles[foot], self._shoe.positions[index], self._shoe.height,
                        BAD if bad else CELL)  # fmt: skip
        if seen.force is not None and seen.cop is not None and seen.force > 0.0:
            ground = np.array([*seen.cop, 0.0])
            yield _arrow("force", self._soles[foot], ground, self._length * seen.force, MEASURED)

    def _centres(self, at: Joints, seen: MeasuredInstant) -> Iterator[Any]:
        left = self._soles[0]
        below = np.array([*at.com[:2], 0.0])
        yield _ball("com", left, at.com, COM)
        yield _line("com", left, np.vstack((at.com, below)), COM)
        yield _ball("cop_modelled", left, below, MODELLED)
        if seen.cop is not None:
            frame = self._soles[seen.frame]
            yield _ball("cop_measured", frame, np.array([*seen.cop, 0.0]), MEASURED)
        if all(one.loaded for one in seen.feet):
            right = np.array([at.soles[1].act(corner) for corner in self._polygons[1]])
            corners = np.vstack((self._polygons[0], right))[:, :2]
            hull = corners[ConvexHull(corners).vertices]
            yield _line("support_polygon", left, _ring(hull), OUTLINE)


def _faces(shape: LinkShape) -> IntArray | None:
    """(f, 3) corners of a hull's triangles, seen from outside; None for balls and capsules."""
    if len(shape.points) < 3:
        return None
    corners = _grown(shape)
    hull = ConvexHull(corners)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (corners[faces[:, index]] for index in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return faces


def _grown(shape: LinkShape) -> FloatArray:
    """Corners of a hull, grown by its radius."""
    if shape.radius == 0.0:
        return shape.points
    steps = np.array(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3)).reshape(3, -1).T
    steps = steps[np.any(steps != 0.0, axis=1)]
    around = shape.radius * steps / np.linalg.norm(steps, axis=1, keepdims=True)
    grown: FloatArray = (shape.points[:, None] + around).reshape(-1, 3)
    return grown


def _solid(frame: str, shape: LinkShape, faces: IntArray | None) -> Iterator[Any]:
    if faces is not None:
        marker = _marker("body", frame, Marker.TRIANGLE_LIST, shape.rgba, (1.0, 1.0, 1.0))
        marker.points = _points(_grown(shape)[faces.ravel()])
        yield marker
        return
    size = 2.0 * shape.radius
    ends = _marker("body", frame, Marker.SPHERE_LIST, shape.rgba, (size, size, size))
    ends.points = _points(shape.points)
    yield ends
    if len(shape.points) == 2:
        low, high = shape.points
        length = float(np.linalg.norm(high - low))
        middle = _marker("body", frame, Marker.CYLINDER, shape.rgba, (size, size, length))
        turn, _ = Rotation.align_vectors([(high - low) / length], [(0.0, 0.0, 1.0)])
        _place(middle, (low + high) / 2.0, turn)
        yield middle


def _arrow(space: str, frame: str, foot: FloatArray, height: float, rgba: Rgba) -> Any:
    marker = _marker(space, frame, Marker.ARROW, rgba, (2.0 * LINE, 5.0 * LINE, 8.0 * LINE))
    marker.points = _points(np.vstack((foot, foot + (0.0, 0.0, height))))  # noqa: RUF005 - a sum
    return marker


def _line(space: str, frame: str, points: FloatArray, rgba: Rgba) -> Any:
    marker = _marker(space, frame, Marker.LINE_STRIP, rgba, (LINE, 0.0, 0.0))
    marker.points = _points(points)
    return marker


def _ball(space: str, frame: str, place: FloatArray, rgba: Rgba) -> Any:
    marker = _marker(space, frame, Marker.SPHERE, rgba, (BALL, BALL, BALL))
    _place(marker, place, Rotation.identity())
    return marker


def _cell(frame: str, place: FloatArray, height: float, rgba: Rgba) -> Any:
    tall = max(0.6 * height, LINE)
    marker = _marker("cells", frame, Marker.CYLINDER, rgba, (BALL, BALL, tall))
    _place(marker, np.array([*place, height / 2.0]), Rotation.identity())
    return marker


def _marker(space: str, frame: str, kind: int, rgba: Rgba, scale: Sequence[float]) -> Any:
    marker = Marker(ns=space, type=kind, action=Marker.ADD)
    marker.header.frame_id = frame
    red, green, blue, alpha = rgba
    marker.color = ColorRGBA(r=red, g=green, b=blue, a=alpha)
    marker.scale.x, marker.scale.y, marker.scale.z = (float(one) for one in scale)
    marker.pose.orientation.w = 1.0
    return marker


def _place(marker: Any, place: FloatArray, turn: Rotation) -> None:
    where, how = marker.pose.position, marker.pose.orientation
    where.x, where.y, where.z = place.tolist()
    how.x, how.y, how.z, how.w = turn.as_quat().tolist()


def _points(points: FloatArray) -> list[Any]:
    return [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]


def _ring(outline: FloatArray) -> FloatArray:
    """A closed outline (k + 1, 3) on the floor."""
    closed = np.vstack((outline, outline[:1]))
    return np.column_stack((closed, np.zeros(len(closed))))
