"""Many lines against time, each in a strip of its own between its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.report.palette import FAIL, INK, MUTED, SOLE, Colour, Look
from shoecal_core.report.svg import SMALL, WIDTH, canvas, draw_line, line_key, readable

FloatArray = NDArray[np.float64]

ROW, GAP, TOP, BOTTOM = 17.0, 5.0, 40.0, 36.0
NUMBERS = 74.0
"""Room for a strip's figures, right of it."""


@dataclass(frozen=True)
class Strip:
    """One quantity against time.

    Attributes:
        label: left of it.
        look: of its line.
        values: (T,).
        low, high: the strip's lower and upper edge.
        limits: drawn across it.
        number: the one that counts most, with unit, right of it.
        worst: sample that this number is of.
        kept: whether the number is as it should be.
    """

    label: str
    look: Look
    values: FloatArray
    low: float
    high: float
    limits: tuple[float, ...]
    number: str
    worst: int
    kept: bool = True


def strips(
    time: FloatArray,
    rows: Sequence[Strip],
    keys: Sequence[tuple[Look, str]],
    edges: str,
    meaning: str,
) -> str:
    """One strip a row over the same time.

    Args:
        time: (T,) [s].
        rows: from above.
        keys: looks and what they mean.
        edges: what a strip's edges are, above the strips.
        meaning: what the number right of each strip is.
    """
    for row in rows:
        if row.values.shape != time.shape:
            raise ShapeError(row.label, str(time.shape), row.values.shape)
    labels = [readable(row.label, 18) for row in rows]
    left = 10.0 + 5.3 * max(map(len, labels))
    right = WIDTH - NUMBERS
    height = (ROW + GAP) * len(rows) - GAP
    with canvas(TOP + height + BOTTOM) as page:
        page.legend([line_key(look, name) for look, name in keys])
        page.write(left, TOP - 7.0, edges, fontsize=SMALL, color=MUTED.light)
        page.write(WIDTH - 4.0, TOP - 7.0, meaning, ha="right", fontsize=SMALL, color=MUTED.light)
        axes = page.panel(TOP, height, left=left, right=right)
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.tick_params(axis="x", length=3.0)
        # One panel for all: a panel each takes ten times as long to draw.
        axes.set_ylim(height, 0.0)
        axes.set_xlim(time[0], time[-1])
        axes.set_yticks([])
        axes.set_xlabel("time (s)")
        for index, (row, label) in enumerate(zip(rows, labels, strict=True)):
            top = index * (ROW + GAP)
            _draw(axes, time, row, top)
            page.write(left - 5.0, TOP + top + ROW / 2.0, label, ha="right", va="center",
                       fontsize=SMALL)  # fmt: skip
            page.write(WIDTH - 4.0, TOP + top + ROW / 2.0, row.number, ha="right", va="center",
                       fontsize=SMALL, color=_mark(row).light)  # fmt: skip
        listed = "; ".join(f"{label} {row.number}" for label, row in zip(labels, rows, strict=True))
        return page.svg(f"Against time [s], {edges}; {meaning}: {listed}.")


def _draw(axes: Axes, time: FloatArray, row: Strip, top: float) -> None:
    """A strip whose upper edge is at a height, in units."""

    def height(values: FloatArray) -> FloatArray:
        """(T,) heights of values on the page."""
        return top + ROW * (row.high - values) / (row.high - row.low)

    axes.axhspan(top, top + ROW, facecolor=SOLE.light, edgecolor="none")
    for limit in height(np.array(row.limits)):
        axes.axhline(limit, color=MUTED.light, linewidth=0.8, dashes=(3.0, 2.0))
    values = height(row.values)
    draw_line(axes, time, values, row.look)
    axes.plot(time[row.worst], values[row.worst], "o", color=_mark(row).light, markersize=3.0,
              clip_on=False)  # fmt: skip


def _mark(row: Strip) -> Colour:
    return INK if row.kept else FAIL
