"""Estimates of many channels with their intervals, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from shoecal_core.report.palette import GUESS, INK, MEASURED
from shoecal_core.report.quantities import true_minus
from shoecal_core.report.svg import WIDTH, canvas, readable

FloatArray = NDArray[np.float64]

ROW, TOP, BOTTOM = 19.0, 24.0, 36.0


@dataclass(frozen=True)
class IntervalColumn:
    """One quantity of all channels.

    Attributes:
        label: with its unit.
        value: (n,) estimates.
        half_width: (n,) of their intervals; NaN where unknown.
        start: (n,) what they started from; NaN where there was nothing.
    """

    label: str
    value: FloatArray
    half_width: FloatArray
    start: FloatArray


def intervals(
    names: Sequence[str], columns: Sequence[IntervalColumn], start: str = "initial guess"
) -> str:
    """One row a channel, one panel a quantity: estimate, 95 % interval, what it started from.

    Args:
        names: of the channels.
        columns: one a panel.
        start: what the estimates started from, in the legend.
    """
    labels = [readable(name, 24) for name in names]
    left = 14.0 + 5.6 * max(map(len, labels))
    gap = 14.0
    width = (WIDTH - left - 10.0 - gap * (len(columns) - 1)) / len(columns)
    height = ROW * len(names)
    rows = np.arange(len(names))
    with canvas(TOP + height + BOTTOM) as page:
        page.legend(_keys(columns, start))
        for index, column in enumerate(columns):
            edge = left + index * (width + gap)
            axes = page.panel(TOP, height, left=edge, right=edge + width)
            axes.plot(column.start, rows, "|", color=GUESS.colour.light, markersize=9.0,
                      markeredgewidth=1.6)  # fmt: skip
            axes.errorbar(column.value, rows, xerr=np.nan_to_num(column.half_width), fmt="o",
                          color=MEASURED.colour.light, markersize=4.5, linewidth=1.5,
                          capsize=2.5)  # fmt: skip
            axes.set_ylim(len(names) - 0.4, -0.6)
            axes.set_yticks(rows, labels if index == 0 else [""] * len(rows))
            axes.tick_params(axis="y", length=0.0, labelcolor=INK.light)
            axes.locator_params(axis="x", nbins=3)
            axes.xaxis.set_major_formatter(FuncFormatter(_tick))
            axes.margins(x=0.08)
            axes.set_xlabel(readable(column.label))
        listed = "; ".join(
            f"{label}: " + ", ".join(f"{c.label} {c.value[row]:.4g}" for c in columns)
            for row, label in enumerate(labels)
        )
        return page.svg(f"Estimates with 95 % intervals. {listed}.")


def _keys(columns: Sequence[IntervalColumn], start: str) -> list[Line2D]:
    keys = [
        Line2D([], [], color=MEASURED.colour.light, marker="o", markersize=4.5, linewidth=1.5,
               label="estimate, 95 % interval")
    ]  # fmt: skip
    if any(np.isfinite(column.start).any() for column in columns):
        keys.append(
            Line2D([], [], linestyle="", color=GUESS.colour.light, marker="|", markersize=9.0,
                   markeredgewidth=1.6, label=start)
        )  # fmt: skip
    return keys


def _tick(value: float, _: object) -> str:
    return true_minus(f"{value:.4g}")
