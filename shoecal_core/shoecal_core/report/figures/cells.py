"""Single cells under known weights: how far each is off its own line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from shoecal_core.report.palette import INK, STEPS
from shoecal_core.report.svg import canvas, readable, y_label

FloatArray = NDArray[np.float64]

MARKERS = "os^DvPX"
PER_LINE, LINE = 2, 17.0
LEFT, HEIGHT, BOTTOM = 52.0, 150.0, 36.0


@dataclass(frozen=True)
class CellLine:
    """One cell.

    Attributes:
        label: its name.
        masses: (L,) that stood on it [kg].
        residuals: (L,) force by its line minus the weight [N].
    """

    label: str
    masses: FloatArray
    residuals: FloatArray


def cell_residuals(cells: Sequence[CellLine]) -> str:
    """Residuals against the masses, one marker a cell."""
    keys = [
        Line2D([], [], linestyle="", marker=MARKERS[index % len(MARKERS)], markersize=4.5,
               markerfacecolor="none", color=STEPS[3 * index % len(STEPS)].light,
               label=readable(cell.label, 24))
        for index, cell in enumerate(cells)
    ]  # fmt: skip
    rows = [keys[start : start + PER_LINE] for start in range(0, len(keys), PER_LINE)]
    top = LINE * len(rows) + 8.0
    with canvas(top + HEIGHT + BOTTOM) as page:
        for index, row in enumerate(rows):
            page.legend(row, left=LEFT - 6.0, top=LINE * index)
        axes = page.panel(top, HEIGHT, left=LEFT)
        axes.axhline(0.0, color=INK.light, linewidth=1.0)
        for key, cell in zip(keys, cells, strict=True):
            axes.plot(cell.masses, 1e3 * cell.residuals, linestyle="", marker=key.get_marker(),
                      markersize=4.5, markerfacecolor="none", color=key.get_color())  # fmt: skip
        axes.margins(x=0.05, y=0.12)
        axes.locator_params(axis="y", nbins=5)
        y_label(axes, "Δ force (mN)")
        axes.set_xlabel("mass on the cell (kg)")
        listed = ", ".join(
            f"{readable(cell.label)} {1e3 * float(np.abs(cell.residuals).max()):.1f}"
            for cell in cells
        )
        return page.svg(f"Single cells off their lines, at most [mN]: {listed}.")
