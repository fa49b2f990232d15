"""Feet and the CoP seen from above, between the feet and under each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from numpy.typing import NDArray

from shoecal_core.report.palette import INK, MUTED, SOLE, Look
from shoecal_core.report.svg import (
    SMALL,
    TEXT,
    WIDTH,
    Canvas,
    canvas,
    draw_line,
    line_key,
    readable,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe

FloatArray = NDArray[np.float64]
MARGIN_MM, ROOM_FOR_LABEL_MM = 8.0, 16.0
LEFT, BOTTOM, TOP = 50.0, 36.0, 44.0


@dataclass(frozen=True)
class FootShape:
    """A foot seen from above, in the frame of the figure.

    Attributes:
        label: for example `left`.
        outline: (k, 2) of the sole [m].
        sensing_polygon: (k, 2) [m].
        cells: (c, 2) places of its channels [m].
    """

    label: str
    outline: FloatArray
    sensing_polygon: FloatArray
    cells: FloatArray


@dataclass(frozen=True)
class CopPath:
    """A CoP on its way.

    Attributes:
        label: for the legend.
        look: of the line.
        points: (T, 2) [m], NaN where there is none.
    """

    label: str
    look: Look
    points: FloatArray


def cop_plane(feet: Sequence[FootShape], paths: Sequence[CopPath]) -> str:
    """CoP paths between the feet, x forward and y to the left."""
    low, high = _extent(feet, paths)
    width = WIDTH - LEFT - 8.0
    scale = min(width / (high[1] - low[1]), 270.0 / (high[0] - low[0]))
    height = scale * (high[0] - low[0])
    with canvas(TOP + height + BOTTOM) as page:
        _legends(page, paths)
        axes = page.panel(TOP, height, left=LEFT)
        spare = width / scale - (high[1] - low[1])
        low[1], high[1] = low[1] - spare / 2.0, high[1] + spare / 2.0
        _draw(axes, feet, paths, low, high)
        axes.set_ylabel("x, forward (mm)")
        axes.yaxis.set_label_coords(-38.0 / width, 0.5)
        axes.set_xlabel("y, to the left (mm)")
        return page.svg(_alt("between the feet", feet, paths))


def cop_under_feet(feet: Sequence[tuple[FootShape, Sequence[CopPath]]]) -> str:
    """CoP paths under each foot in its own sole frame; as many panels as feet."""
    extents = [_extent([foot], paths) for foot, paths in feet]
    span = np.max([high - low for low, high in extents], axis=0)
    gap = 30.0
    width = (WIDTH - LEFT - 8.0 - gap * (len(feet) - 1)) / len(feet)
    scale = min(width / span[1], 300.0 / span[0])
    height = scale * span[0]
    with canvas(TOP + 14.0 + height + BOTTOM) as page:
        _legends(page, feet[0][1])
        for index, ((foot, paths), (low, high)) in enumerate(zip(feet, extents, strict=True)):
            left = LEFT + index * (width + gap)
            axes = page.panel(TOP + 14.0, height, left=left, right=left + width)
            middle, half = (low + high) / 2.0, np.array([height, width]) / scale / 2.0
            _draw(axes, [foot], paths, middle - half, middle + half, named=False)
            axes.set_title(f"{readable(foot.label)} foot", pad=4.0, fontsize=TEXT)
            axes.set_xlabel("y (mm)")
            if index == 0:
                axes.set_ylabel("x, forward (mm)")
                axes.yaxis.set_label_coords(-38.0 / width, 0.5)
        return page.svg(_alt("under each foot", [foot for foot, _ in feet], feet[0][1]))


def _alt(where: str, feet: Sequence[FootShape], paths: Sequence[CopPath]) -> str:
    names = ", ".join(readable(path.label) for path in paths)
    cells = ", ".join(f"{len(foot.cells)} {foot.label}" for foot in feet)
    return f"CoP {where} seen from above: {names}; with soles, sensing polygons, cells ({cells})."


def _extent(feet: Sequence[FootShape], paths: Sequence[CopPath]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y) of the soles and of all paths near them [mm]."""
    soles = np.vstack([foot.outline for foot in feet] + [foot.cells for foot in feet])
    low, high = soles.min(axis=0), soles.max(axis=0)
    reach = 0.15 * (high - low).max()
    for path in paths:
        points = path.points[np.isfinite(path.points).all(axis=1)]
        if len(points):
            low = np.minimum(low, np.maximum(points.min(axis=0), low - reach))
            high = np.maximum(high, np.minimum(points.max(axis=0), high + reach))
    return 1e3 * low - [ROOM_FOR_LABEL_MM, MARGIN_MM], 1e3 * high + MARGIN_MM


def _draw(
    axes: Axes,
    feet: Sequence[FootShape],
    paths: Sequence[CopPath],
    low: FloatArray,
    high: FloatArray,
    *,
    named: bool = True,
) -> None:
    draw_feet(axes, feet, named=named)
    for path in paths:
        x, y = 1e3 * path.points.T
        draw_line(axes, y, x, path.look)
    axes.set_ylim(low[0], high[0])
    axes.set_xlim(high[1], low[1])
    axes.locator_params(nbins=5)


def draw_feet(axes: Axes, feet: Sequence[FootShape], *, named: bool = True) -> None:
    """Soles, sensing polygons and cells, x upwards and y to the left [mm]."""
    axes.grid(visible=False)
    for foot in feet:
        axes.add_patch(Polygon(1e3 * foot.outline[:, ::-1], facecolor=SOLE.light, edgecolor="none"))
        axes.add_patch(
            Polygon(
                1e3 * foot.sensing_polygon[:, ::-1],
                facecolor="none",
                edgecolor=MUTED.light,
                linewidth=0.9,
            )
        )
        x, y = 1e3 * foot.cells.T
        axes.plot(y, x, "o", markersize=5.0, markerfacecolor="none", color=INK.light)
        if named:
            corner = foot.outline[foot.outline[:, 0] < foot.outline[:, 0].min() + 1e-3]
            rear, across = 1e3 * corner.mean(axis=0)
            axes.text(
                across, rear - 2.0, readable(foot.label), ha="center", va="top", fontsize=SMALL
            )


def _legends(page: Canvas, paths: Sequence[CopPath]) -> None:
    page.legend([line_key(path.look, path.label) for path in paths], left=LEFT - 6.0)
    page.legend(shape_keys(), left=LEFT - 6.0, top=18.0)


def shape_keys() -> list[Artist]:
    """Legend entries of what belongs to a foot."""
    return [
        Patch(facecolor=SOLE.light, edgecolor="none", label="sole"),
        Patch(facecolor="none", edgecolor=MUTED.light, linewidth=0.9, label="sensing polygon"),
        Line2D([], [], linestyle="", marker="o", markersize=5.0, markerfacecolor="none",
               color=INK.light, label="cell"),
    ]  # fmt: skip


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
