"""Feet and the CoP seen from above, between the feet and under each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Polygon

from shoecal_core.arrays import FloatArray
from shoecal_core.report.palette import INK, MUTED, SOLE, Look
from shoecal_core.report.svg import (
    LINE,
    SMALL,
    TEXT,
    WIDTH,
    Canvas,
    area_key,
    canvas,
    draw_line,
    line_key,
    marker_key,
    readable,
    y_label,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe

MARGIN_MM, ROOM_FOR_LABEL_MM = 8.0, 16.0
LEFT, RIGHT, BOTTOM, GAP = 50.0, 8.0, 36.0, 30.0
TITLE, BAND = 16.0, 26.0


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


@dataclass(frozen=True)
class Above:
    """One panel that is seen from above.

    Attributes:
        low, high: (2,) corners (x, y) of what it shows at least [mm].
        draw: into its axes, with the scale in units a millimetre.
        title: above it.
    """

    low: FloatArray
    high: FloatArray
    draw: Callable[[Axes, float], None]
    title: str = ""


def from_above(
    panels: Sequence[Above],
    legends: Sequence[Sequence[Artist]],
    alt: str,
    *,
    tallest: float = 270.0,
    band: Callable[[Canvas, float], None] | None = None,
) -> str:
    """Panels side by side and to one scale, x forward and y to the left.

    Args:
        panels: from the left.
        legends: rows above them.
        alt: what is to be seen.
        tallest: units of height of a panel.
        band: draws what stands between legends and panels, BAND units high, from a top on.
    """
    span = np.max([one.high - one.low for one in panels], axis=0)
    width = (WIDTH - LEFT - RIGHT - GAP * (len(panels) - 1)) / len(panels)
    scale = min(width / span[1], tallest / span[0])
    half = np.array([scale * span[0], width]) / scale / 2.0
    under = LINE * len(legends) + 6.0
    top = under + (BAND if band else 0.0) + (TITLE if any(one.title for one in panels) else 0.0)
    with canvas(top + scale * span[0] + BOTTOM) as page:
        for row, keys in enumerate(legends):
            page.legend(keys, left=LEFT - 6.0, top=LINE * row)
        if band:
            band(page, under)
        for index, one in enumerate(panels):
            left = LEFT + index * (width + GAP)
            axes = page.panel(top, scale * span[0], left=left, right=left + width)
            one.draw(axes, scale)
            middle = (one.low + one.high) / 2.0
            axes.set_ylim(middle[0] - half[0], middle[0] + half[0])
            axes.set_xlim(middle[1] + half[1], middle[1] - half[1])
            axes.locator_params(nbins=5)
            axes.set_title(readable(one.title, 36), pad=4.0, fontsize=TEXT)
            axes.set_xlabel("y, to the left (mm)" if len(panels) == 1 else "y (mm)")
            if index == 0:
                y_label(axes, "x, forward (mm)")
        return page.svg(alt)


def around(points: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y) of points (k, 2) [m], with a margin [mm]."""
    every = 1e3 * np.vstack(points)
    return every.min(axis=0) - MARGIN_MM, every.max(axis=0) + MARGIN_MM


def cop_plane(feet: Sequence[FootShape], paths: Sequence[CopPath]) -> str:
    """CoP paths between the feet, x forward and y to the left."""
    panel = Above(*_extent(feet, paths), partial(_draw, feet, paths, named=True))
    return from_above([panel], _legends(paths), _alt("between the feet", feet, paths))


def cop_under_feet(feet: Sequence[tuple[FootShape, Sequence[CopPath]]]) -> str:
    """CoP paths under each foot in its own sole frame; as many panels as feet."""
    panels = [
        Above(*_extent([foot], paths), partial(_draw, [foot], paths, named=False),
              f"{foot.label} foot")
        for foot, paths in feet
    ]  # fmt: skip
    alt = _alt("under each foot", [foot for foot, _ in feet], feet[0][1])
    return from_above(panels, _legends(feet[0][1]), alt, tallest=300.0)


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
    feet: Sequence[FootShape], paths: Sequence[CopPath], axes: Axes, _: float, *, named: bool
) -> None:
    draw_feet(axes, feet, named=named)
    for path in paths:
        x, y = 1e3 * path.points.T
        draw_line(axes, y, x, path.look)


def draw_feet(axes: Axes, feet: Sequence[FootShape], *, named: bool = True) -> None:
    """Soles, sensing polygons and cells, x upwards and y to the left [mm]."""
    axes.grid(visible=False)
    for foot in feet:
        # Below all else, a map of errors too.
        axes.add_patch(Polygon(1e3 * foot.outline[:, ::-1], facecolor=SOLE.light, edgecolor="none",
                               zorder=0.5))  # fmt: skip
        draw_outline(axes, foot.sensing_polygon, Look(MUTED, 0.9))
        x, y = 1e3 * foot.cells.T
        axes.plot(y, x, "o", markersize=5.0, markerfacecolor="none", color=INK.light)
        if named:
            corner = foot.outline[foot.outline[:, 0] < foot.outline[:, 0].min() + 1e-3]
            rear, across = 1e3 * corner.mean(axis=0)
            axes.text(
                across, rear - 2.0, readable(foot.label), ha="center", va="top", fontsize=SMALL
            )


def draw_outline(axes: Axes, corners: FloatArray, look: Look) -> None:
    """A line around corners (k, 2) [m], x upwards and y to the left [mm]."""
    dashes = (0, look.dashes) if look.dashes else "-"
    axes.add_patch(Polygon(1e3 * corners[:, ::-1], facecolor="none", edgecolor=look.colour.light,
                           linewidth=look.width, linestyle=dashes))  # fmt: skip


def _legends(paths: Sequence[CopPath]) -> list[Sequence[Artist]]:
    return [[line_key(path.look, path.label) for path in paths], shape_keys()]


def shape_keys() -> list[Artist]:
    """Legend entries of what belongs to a foot."""
    return [area_key(SOLE, "sole"), polygon_key(), marker_key("o", INK, "cell", 5.0)]


def polygon_key() -> Patch:
    """Legend entry of a sensing polygon."""
    return Patch(facecolor="none", edgecolor=MUTED.light, linewidth=0.9, label="sensing polygon")


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
