"""What is left of a signal against what a candidate would change in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shoecal_core.report.palette import MUTED, Look
from shoecal_core.report.svg import SMALL, canvas, line_key, readable, y_label

FloatArray = NDArray[np.float64]

TOP, HEIGHT, GAP, BOTTOM, LEFT = 24.0, 104.0, 40.0, 36.0, 52.0
BINS = 8
LEAST_IN_BIN = 8
MOST_DOTS = 250
LEAST_SPAN = 0.25
"""No means are drawn of a candidate that changes less than this part of what the best does."""


@dataclass(frozen=True)
class Added:
    """One candidate.

    Attributes:
        label: of it.
        change: (k,) what it changes in the residual, in the figure's unit.
        before, after: (k,) residual without and with it.
    """

    label: str
    change: FloatArray
    before: FloatArray
    after: FloatArray


def added_variables(
    candidates: Sequence[Added], looks: tuple[Look, Look], unit: str, signal: str
) -> str:
    """A panel a candidate, all to one scale: dots are samples, lines means of many."""
    across = _ends([one.change for one in candidates])
    upwards = _ends([values for one in candidates for values in (one.before, one.after)])
    height = TOP + (HEIGHT + GAP) * len(candidates) - GAP + BOTTOM + 14.0
    with canvas(height) as page:
        page.legend([line_key(looks[0], "without it"), line_key(looks[1], "with it in the model")],
                    left=LEFT - 6.0)  # fmt: skip
        for index, one in enumerate(candidates):
            axes = page.panel(TOP + 14.0 + index * (HEIGHT + GAP), HEIGHT, left=LEFT)
            axes.set_title(readable(one.label, 52), loc="left", pad=4.0, fontsize=SMALL + 0.5)
            axes.axhline(0.0, color=MUTED.light, linewidth=0.8)
            axes.axline((0.0, 0.0), slope=1.0, color=MUTED.light, linewidth=0.8, dashes=(3.0, 2.0))
            for values, look in zip((one.before, one.after), looks, strict=True):
                _dots(axes, one.change, values, look)
            if np.ptp(one.change) > LEAST_SPAN * (across[1] - across[0]):
                for values, look in zip((one.before, one.after), looks, strict=True):
                    _means(axes, one.change, values, look)
            axes.set_xlim(*across)
            axes.set_ylim(*upwards)
            axes.locator_params(axis="y", nbins=4)
            y_label(axes, f"residual ({unit})")
            axes.tick_params(labelbottom=index == len(candidates) - 1)
        axes.set_xlabel(f"what it changes ({unit})")
        listed = "; ".join(
            f"{one.label}: slope {slope(one.change, one.before):.2f} without, "
            f"{slope(one.change, one.after):.2f} with it"
            for one in candidates
        )
        return page.svg(f"Residual of the {signal} against what candidates change in it. {listed}.")


def _ends(values: Sequence[FloatArray]) -> tuple[float, float]:
    """Nearly all of it, and nothing, with a little room."""
    ends = np.array([np.quantile(one, (0.005, 0.995)) for one in values])
    low, high = min(float(ends.min()), 0.0), max(float(ends.max()), 0.0)
    room = max(0.06 * (high - low), 1e-9)
    return low - room, high + room


def slope(change: FloatArray, values: FloatArray) -> float:
    """Slope of the best line through the origin for points (T,), (T,); 0 where nothing changes."""
    square = float(change @ change)
    return float(change @ values) / square if square > 0.0 else 0.0


def _dots(axes: Axes, x: FloatArray, y: FloatArray, look: Look) -> None:
    step = max(1, len(x) // MOST_DOTS)
    axes.plot(x[::step], y[::step], ".", color=look.colour.light, markersize=2.4, alpha=0.45)


def _means(axes: Axes, x: FloatArray, y: FloatArray, look: Look) -> None:
    edges = np.quantile(x, np.linspace(0.0, 1.0, BINS + 1))
    owner = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, BINS - 1)
    bins = [owner == index for index in range(BINS)]
    means = [(x[rows].mean(), y[rows].mean()) for rows in bins if rows.sum() >= LEAST_IN_BIN]
    if means:
        places, heights = np.array(means).T
        axes.plot(places, heights, "o-", color=look.colour.light, linewidth=2.0, markersize=3.5)
