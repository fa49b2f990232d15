"""Many lines against time, each in a strip of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.report.palette import FAIL, INK, MUTED, ONSET, RULE, SOLE, Look
from shoecal_core.report.svg import LINE, SMALL, WIDTH, canvas, draw_line, readable

GAP, BOTTOM = 5.0, 36.0
PER_LINE = 3
"""Entries in one line of the legend."""
NUMBERS = 80.0
"""Room for a strip's figures, right of it."""


@dataclass(frozen=True)
class Strip:
    """Lines of one quantity against time.

    Attributes:
        label: left of it.
        time: (T,) [s].
        lines: look and values (T,) of each; the first one drawn first.
        low, high: the strip's lower and upper edge; lines end there.
        number: the one that counts most, with unit, right of it.
        limits: drawn across it.
        band: shaded from and to; None: all of it.
        worst: sample of the first line that the number is of.
        kept: whether the number is as it should be.
        lifted: stretches in which a foot hangs [s].
        onsets: when something begins [s].
    """

    label: str
    time: FloatArray
    lines: tuple[tuple[Look, FloatArray], ...]
    low: float
    high: float
    number: str
    limits: tuple[float, ...] = ()
    band: tuple[float, float] | None = None
    worst: int | None = None
    kept: bool = True
    lifted: tuple[tuple[float, float], ...] = ()
    onsets: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for _, values in self.lines:
            if values.shape != self.time.shape:
                raise ShapeError(self.label, str(self.time.shape), values.shape)


def strips(
    rows: Sequence[Strip], keys: Sequence[Artist], edges: str, meaning: str, tall: float = 17.0
) -> str:
    """One strip a row over the same time.

    Args:
        rows: from above.
        keys: legend.
        edges: what a strip's edges are, above the strips.
        meaning: what the number right of each strip is.
        tall: height of a strip in units.
    """
    labels = [readable(row.label, 18) for row in rows]
    left = 10.0 + 5.3 * max(map(len, labels))
    height = (tall + GAP) * len(rows) - GAP
    first = LINE * -(-len(keys) // PER_LINE) + 23.0
    with canvas(first + height + BOTTOM) as page:
        page.legends(keys, PER_LINE)
        page.write(0.0, first - 7.0, edges, fontsize=SMALL, color=MUTED.light)
        page.write(WIDTH - 4.0, first - 7.0, meaning, ha="right", fontsize=SMALL, color=MUTED.light)
        axes = page.panel(first, height, left=left, right=WIDTH - NUMBERS)
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.tick_params(axis="x", length=3.0)
        # One panel for all: a panel each takes ten times as long to draw.
        axes.set_ylim(height, 0.0)
        axes.set_xlim(rows[0].time[0], max(float(row.time[-1]) for row in rows))
        axes.set_yticks([])
        axes.set_xlabel("time (s)")
        for index, (row, label) in enumerate(zip(rows, labels, strict=True)):
            top = index * (tall + GAP)
            _draw(axes, row, top, tall)
            middle = first + top + tall / 2.0
            page.write(left - 5.0, middle, label, ha="right", va="center", fontsize=SMALL)
            page.write(WIDTH - 4.0, middle, row.number, ha="right", va="center", fontsize=SMALL,
                       color=(INK if row.kept else FAIL).light)  # fmt: skip
        listed = "; ".join(f"{label} {row.number}" for label, row in zip(labels, rows, strict=True))
        return page.svg(f"Against time [s], {edges}; {meaning}: {listed}.")


def _draw(axes: Axes, row: Strip, top: float, tall: float) -> None:
    """A strip whose upper edge is at a height, in units."""

    def height(values: FloatArray) -> FloatArray:
        """(T,) heights of values on the page."""
        inside = np.clip(values, row.low, row.high)
        return np.asarray(top + tall * (row.high - inside) / (row.high - row.low))

    ends = (float(row.time[0]), float(row.time[-1]))
    for start, stop in row.lifted:
        axes.fill_between((start, stop), top, top + tall, color=RULE.light, linewidth=0.0)
    lower, upper = height(np.array(row.band or (row.low, row.high)))
    axes.fill_between(ends, upper, lower, color=SOLE.light, linewidth=0.0)
    for limit in height(np.array(row.limits)):
        axes.axhline(limit, color=MUTED.light, linewidth=0.8, dashes=(3.0, 2.0))
    for look, values in row.lines:
        draw_line(axes, row.time, height(values), look)
    if row.worst is not None:
        axes.plot(row.time[row.worst], height(row.lines[0][1])[row.worst], "o", markersize=3.0,
                  color=(INK if row.kept else FAIL).light, clip_on=False)  # fmt: skip
    for onset in row.onsets:
        draw_line(axes, np.array((onset, onset)), np.array((top, top + tall)), ONSET)
        axes.annotate(f"{onset:.1f} s", (onset, top), (3.0, -6.0), textcoords="offset points",
                      fontsize=SMALL, color=INK.light)  # fmt: skip
