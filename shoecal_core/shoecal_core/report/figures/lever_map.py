"""Where a wrong force would have to act: the density of lever points over the soles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from shoecal_core.report.figures.plane import FootShape, draw_feet, shape_keys
from shoecal_core.report.palette import INK, SIZES
from shoecal_core.report.svg import SMALL, TEXT, WIDTH, Canvas, canvas, readable

FloatArray = NDArray[np.float64]

LEFT, RIGHT, TOP, BOTTOM, GAP = 50.0, 8.0, 60.0, 36.0, 30.0
TALLEST = 270.0
MARGIN = 0.012
"""Shown around a sole [m]."""
LEVELS = (0.15, 0.3, 0.5, 0.7, 0.9, 1.0)
"""Borders of the colours, in parts of the greatest density of all panels."""


@dataclass(frozen=True)
class LeverMap:
    """One foot.

    Attributes:
        shape: in its own sole frame.
        x, y: (r,) axes of the density [m].
        density: (r, r) [1/m^2].
        peak: (2,) where it is greatest [m].
        note: below the foot's name.
    """

    shape: FootShape
    x: FloatArray
    y: FloatArray
    density: FloatArray
    peak: FloatArray
    note: str


def box(shape: FootShape) -> tuple[FloatArray, FloatArray]:
    """(2,) lowest and (2,) highest place that is shown of a foot, sole frame [m]."""
    every = np.vstack((shape.outline, shape.cells))
    return every.min(axis=0) - MARGIN, every.max(axis=0) + MARGIN


def lever_map(maps: Sequence[LeverMap]) -> str:
    """One panel a foot, in common colours; a cross marks the densest place of all."""
    boxes = [box(one.shape) for one in maps]
    span = 1e3 * np.max([high - low for low, high in boxes], axis=0)
    width = (WIDTH - LEFT - RIGHT - GAP * (len(maps) - 1)) / len(maps)
    scale = min(width / span[1], TALLEST / span[0])
    height = scale * span[0]
    greatest = max(float(one.density.max()) for one in maps)
    with canvas(TOP + 16.0 + height + BOTTOM) as page:
        _legends(page)
        for index, (one, (low, high)) in enumerate(zip(maps, boxes, strict=True)):
            left = LEFT + index * (width + GAP)
            axes = page.panel(TOP + 16.0, height, left=left, right=left + width)
            draw_feet(axes, [one.shape], named=False)
            if greatest > 0.0:
                _draw(axes, one, greatest)
            middle, half = 500.0 * (low + high), np.array([height, width]) / scale / 2.0
            axes.set_ylim(middle[0] - half[0], middle[0] + half[0])
            axes.set_xlim(middle[1] + half[1], middle[1] - half[1])
            axes.locator_params(nbins=5)
            axes.set_title(f"{readable(one.shape.label)} foot", pad=16.0, fontsize=TEXT)
            axes.annotate(readable(one.note, 36), (0.5, 1.0), (0.0, 4.0), xycoords="axes fraction",
                          textcoords="offset points", ha="center", fontsize=SMALL)  # fmt: skip
            axes.set_xlabel("y (mm)")
            if index == 0:
                axes.set_ylabel("x, forward (mm)")
                axes.yaxis.set_label_coords(-38.0 / width, 0.5)
        listed = "; ".join(f"{one.shape.label} foot: {one.note}" for one in maps)
        return page.svg(f"Density of lever points over the soles. {listed}.")


def _draw(axes: Axes, one: LeverMap, greatest: float) -> None:
    if one.density.max() > LEVELS[0] * greatest:
        axes.contourf(
            1e3 * one.y, 1e3 * one.x, one.density / greatest, levels=LEVELS,
            colors=[colour.light for colour in SIZES[1:]], zorder=1.5,
        )  # fmt: skip
    if one.density.max() == greatest:
        axes.plot(1e3 * one.peak[1], 1e3 * one.peak[0], "x", color=INK.light, markersize=8.0,
                  markeredgewidth=2.0, zorder=4.0)  # fmt: skip


def _legends(page: Canvas) -> None:
    keys: list[Patch | Line2D] = [
        Patch(facecolor=SIZES[1].light, edgecolor="none", label="some samples point here"),
        Patch(facecolor=SIZES[-1].light, edgecolor="none", label="most"),
        Line2D([], [], linestyle="", marker="x", markersize=7.0, markeredgewidth=2.0,
               color=INK.light, label="densest"),
    ]  # fmt: skip
    page.legend(keys, left=LEFT - 6.0)
    page.legend(shape_keys(), left=LEFT - 6.0, top=18.0)
