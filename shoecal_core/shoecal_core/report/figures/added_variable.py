"""What is left of a signal against what a candidate would change in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shoecal_core.report.palette import MUTED, Look
from shoecal_core.report.svg import SMALL, WIDTH, canvas, line_key, readable

FloatArray = NDArray[np.float64]

TOP, HEIGHT, GAP, BOTTOM, LEFT = 24.0, 104.0, 40.0, 36.0, 52.0
BINS = 8
LEAST_IN_BIN = 8
MOST_DOTS = 250
LEAST_SPAN = 0.5
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
    reach = max(float(np.quantile(np.abs(one.change), 0.995)) for one in candidates)
    tall = max(float(np.quantile(np.abs(one.before), 0.995)) for one in candidates)
    reach, tall = max(reach, 1e-9), max(tall, 1e-9)
    height = TOP + (HEIGHT + GAP) * len(candidates) - GAP + BOTTOM + 14.0
    with canvas(height) as page:
        page.legend([line_key(looks[0], "without it"), line_key(looks[1], "with it in the model")],
                    left=LEFT - 6.0)  # fmt: skip
        for index, one in enumerate(candidates):
            axes = page.panel(TOP + 14.0 + index * (HEIGHT + GAP), HEIGHT, left=LEFT)
            axes.set_title(readable(one.label, 52), loc="left", pad=4.0, fontsize=SMALL + 0.5)
            axes.axhline(0.0, color=MUTED.light, linewidth=0.8)
            for values, look in zip((one.before, one.after), looks, strict=True):
                _dots(axes, one.change, values, look)
            if np.ptp(one.change) > LEAST_SPAN * reach:
                for values, look in zip((one.before, one.after), looks, strict=True):
                    _means(axes, one.change, values, look)
            axes.set_xlim(-1.05 * reach, 1.05 * reach)
            axes.set_ylim(-1.1 * tall, 1.1 * tall)
            axes.locator_params(axis="y", nbins=4)
            axes.set_ylabel(f"residual ({unit})")
            axes.yaxis.set_label_coords(-40.0 / (WIDTH - LEFT - 8.0), 0.5)
            axes.tick_params(labelbottom=index == len(candidates) - 1)
        axes.set_xlabel(f"what it changes ({unit})")
        told = "; ".join(
            f"{one.label}: slope {slope(one.change, one.before):.2f} without, "
            f"{slope(one.change, one.after):.2f} with it"
            for one in candidates
        )
        return page.svg(f"Residual of the {signal} against what candidates change in it. {told}.")


def slope(change: FloatArray, values: FloatArray) -> float:
    """Of the line through the origin that fits best; 0 where nothing changes."""
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
