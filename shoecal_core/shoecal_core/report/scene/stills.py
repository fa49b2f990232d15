"""A robot in motion: pictures of some instants side by side, for a page."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from shoecal_core.report.page import Still
from shoecal_core.report.scene.body import Joints, body_shapes, joints_at
from shoecal_core.report.scene.offscreen import Viewpoint, draw, framed
from shoecal_core.report.scene.shapes import (
    LinkShape,
    Rgba,
    arrow,
    dashes,
    disc,
    gathered,
    path,
    prism,
)
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

FloatArray = NDArray[np.float64]

WIDTH, HEIGHT = 280, 390
"""Pixels of one picture; a page shows it at about two thirds of that."""
AZIMUTH, ELEVATION = 155.0, -24.0
"""deg: from the front, a little from the robot's right and from above."""
MARGIN, THICKNESS = 0.02, 0.008
"""m: of the floor about the feet."""
FORCE_HEIGHT = 0.75
"""Height of the arrow that stands for the robot's weight, over its CoM's height."""

FLOOR: Rgba = (0.55, 0.59, 0.64, 1.0)
POLYGON: Rgba = (0.80, 0.84, 0.88, 1.0)
COP: Rgba = (0.80, 0.12, 0.16, 1.0)
COM: Rgba = (0.20, 0.24, 0.28, 1.0)


@dataclass(frozen=True)
class StillInstant:
    """One picture's moment.

    Attributes:
        label: below the picture.
        at: the body.
        cop: (2,) in the world, on the floor [m]; NaN where there is none.
        load: force on the floor over the robot's weight.
        trail: (k, 2) where the CoP has been [m].
    """

    label: str
    at: Joints
    cop: FloatArray
    load: float
    trail: FloatArray


def instant(
    robot: Robot,
    label: str,
    angles: FloatArray,
    cop: FloatArray,
    load: float,
    trail: FloatArray,
    stance: int = 0,
    pose: pin.SE3 | None = None,
) -> StillInstant:
    """The moment of joint angles (m,) [rad]; arguments of `joints_at` and StillInstant."""
    return StillInstant(label, joints_at(robot, angles, stance, pose), cop, load, trail)


def stills(
    robot: Robot, shoe: Shoe, motions: Sequence[Sequence[StillInstant]]
) -> list[tuple[Still, ...]]:
    """Pictures of instants of each motion, all of one motion from one place of view.

    Raises:
        NoPictureError: where nothing can draw them.
    """
    size = WIDTH, HEIGHT
    wanted = [view for instants in motions for view in views(robot, shoe, instants, size)]
    files = iter(draw(wanted))
    return [tuple(_still(next(files), one) for one in instants) for instants in motions]


def views(
    robot: Robot, shoe: Shoe, instants: Sequence[StillInstant], size: tuple[int, int]
) -> list[Viewpoint]:
    """What to draw of one motion, from one place of view; width and height in pixels."""
    floor = _floor(robot, instants)
    scenes = [gathered((body_shapes(robot, shoe, one.at), floor, _forces(one)))
              for one in instants]  # fmt: skip
    width, height = size
    camera = framed(gathered(scenes), AZIMUTH, ELEVATION, width / height)
    return [Viewpoint(scene, camera, width, height) for scene in scenes]


def _still(file: bytes, one: StillInstant) -> Still:
    uri = f"data:image/webp;base64,{base64.b64encode(file).decode()}"
    return Still(uri, one.label, f"The robot at {one.label}.", WIDTH, HEIGHT)


def _floor(robot: Robot, instants: Sequence[StillInstant]) -> tuple[LinkShape, ...]:
    """A slab under all that is stood on, and the hull of the sensing polygons where they stand."""
    outlines = [_placed(one.at, robot.feet[side].outline, side) for one in instants
                for side in (0, 1)]  # fmt: skip
    low, high = np.vstack(outlines).min(axis=0) - MARGIN, np.vstack(outlines).max(axis=0) + MARGIN
    slab = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    first = instants[0].at
    polygons = [_placed(first, foot.sensing_polygon, side) for side, foot in enumerate(robot.feet)]
    corners = np.vstack(polygons)
    hull = corners[ConvexHull(corners).vertices]
    return (
        LinkShape(prism(slab, -THICKNESS, -0.0005), 0.0, FLOOR),
        LinkShape(prism(hull, -THICKNESS, 0.0005), 0.0, POLYGON),
    )


def _placed(at: Joints, outline: FloatArray, side: int) -> FloatArray:
    points = np.column_stack((outline, np.zeros(len(outline))))
    return np.array([at.soles[side].act(point)[:2] for point in points])


def _forces(one: StillInstant) -> tuple[LinkShape, ...]:
    """CoM with its ground projection; the force on the floor at the CoP, and the CoP's trail."""
    height = float(one.at.com[2])
    thick = 0.016 * height
    below = np.array([*one.at.com[:2], 0.0])
    trail = path(np.column_stack((one.trail, np.full(len(one.trail), 0.001))), 0.6 * thick, COP)
    shapes: tuple[LinkShape, ...] = (
        *dashes(below, np.array(one.at.com), 0.5 * thick, COM),
        *trail,
    )
    if np.isfinite(one.cop).all() and one.load > 0.0:
        ground = np.array([*one.cop, 0.0])
        mark = LinkShape(prism(disc(one.cop, 2.5 * thick), 0.0005, 0.002), 0.0, COP)
        reach = max(FORCE_HEIGHT * height * one.load, 8.0 * thick)
        shapes += (mark, *arrow(ground, reach, thick, COP))
    return shapes
