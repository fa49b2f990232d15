"""A shoe under known weights: its force against theirs, its CoP where they stood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.report.figures.feet import FootShape
from shoecal_core.report.palette import BLUE, INK, MUTED, SOLE, STEPS
from shoecal_core.report.svg import WIDTH, canvas

FloatArray = NDArray[np.float64]

MARKERS = "os^DvPX"
"""One for each weight, in addition to its colour."""
TOP, LEFT = 40.0, 52.0
HIGHEST = 400.0


@dataclass(frozen=True)
class KnownLoads:
    """N loads of one shoe.

    Attributes:
        foot: the shoe seen from above.
        masses: (N,) [kg].
        force, expected_force: (N,) [N].
        places: (N, 2) where each weight stood [m].
        measured, corrected: (N, 2) where its CoP was found, without and with the correction [m].
    """

    foot: FootShape
    masses: FloatArray
    force: FloatArray
    expected_force: FloatArray
    places: FloatArray
    measured: FloatArray
    corrected: FloatArray

    def __post_init__(self) -> None:
        count = len(self.masses)
        for name, shape in (
            ("force", (count,)), ("expected_force", (count,)), ("places", (count, 2)),
            ("measured", (count, 2)), ("corrected", (count, 2)),
        ):  # fmt: skip
            found = getattr(self, name).shape
            if found != shape:
                raise ShapeError(f"loads.{name}", str(shape), found)


def forces_under_loads(loads: KnownLoads) -> str:
    """Force of every load, by weight, on the line of what it should be; below, its error."""
    order = np.argsort(loads.masses, kind="stable")
    number = np.arange(1, len(order) + 1)
    force, expected = loads.force[order], loads.expected_force[order]
    colour = BLUE.light
    with canvas(276.0) as page:
        page.legend(
            [
                Line2D([], [], color=INK.light, linewidth=1.4, label="weight"),
                Line2D([], [], linestyle="", marker="o", markersize=4.0, markerfacecolor="none",
                       color=colour, label="measured, one circle a hole"),
            ],
            left=LEFT - 6.0,
        )  # fmt: skip
        axes = page.panel(24.0, 128.0, left=LEFT)
        for level in np.unique(expected):
            at = number[expected == level]
            axes.hlines(level, at[0] - 0.5, at[-1] + 0.5, color=INK.light, linewidth=1.4)
        axes.plot(number, force, "o", markersize=4.0, markerfacecolor="none", color=colour,
                  markeredgewidth=0.8)  # fmt: skip
        axes.set_ylabel("GRF (N)")
        axes.tick_params(labelbottom=False)
        below = page.panel(168.0, 72.0, left=LEFT)
        below.axhline(0.0, color=INK.light, linewidth=1.0)
        below.plot(number, 1e3 * (force - expected), "o", markersize=2.5, color=colour)
        below.set_ylabel("Δ GRF (mN)")
        below.set_xlabel("load, lightest weight first")
        for panel, height in ((axes, 128.0), (below, 72.0)):
            panel.set_xlim(0.0, len(order) + 1.0)
            panel.locator_params(axis="y", nbins=5 if height > 100.0 else 3)
            panel.yaxis.set_label_coords(-0.115, 0.5)
        error = np.abs(force - expected)
        return page.svg(
            f"Measured force of {len(order)} loads on the {loads.foot.label} shoe against their "
            f"weights: mean absolute error {error.mean():.3f} N."
        )


def cop_under_loads(loads: KnownLoads, *, corrected: bool) -> str:
    """CoP of every load, by weight, around the hole in which it stood."""
    found = loads.corrected if corrected else loads.measured
    masses = np.unique(loads.masses)
    low, high = _extent(loads)
    width = WIDTH - LEFT - 8.0
    scale = min(width / (high[1] - low[1]), HIGHEST / (high[0] - low[0]))
    height = scale * (high[0] - low[0])
    with canvas(TOP + height + 36.0) as page:
        keys = _mass_keys(masses)
        page.legend(keys, left=LEFT - 6.0)
        page.legend(_shape_keys(), left=LEFT - 6.0, top=17.0)
        axes = page.panel(TOP, height, left=LEFT)
        spare = (width / scale - (high[1] - low[1])) / 2.0
        _draw_shoe(axes, loads)
        for index, mass in enumerate(masses):
            x, y = 1e3 * found[loads.masses == mass].T
            axes.plot(y, x, _marker(index), markersize=3.6, markerfacecolor="none",
                      markeredgewidth=0.9, color=_colour(index))  # fmt: skip
        axes.set_ylim(low[0], high[0])
        axes.set_xlim(high[1] + spare, low[1] - spare)
        axes.locator_params(nbins=6)
        axes.set_ylabel("x, forward (mm)")
        axes.yaxis.set_label_coords(-0.115, 0.5)
        axes.set_xlabel("y, to the left (mm)")
        error = 1e3 * np.linalg.norm(found - loads.places, axis=1)
        return page.svg(
            f"CoP of {len(found)} loads on the {loads.foot.label} shoe around their holes, "
            f"{'corrected' if corrected else 'as measured'}: mean error {error.mean():.2f} mm."
        )


def _draw_shoe(axes: Axes, loads: KnownLoads) -> None:
    axes.grid(visible=False)
    axes.add_patch(
        Polygon(1e3 * loads.foot.outline[:, ::-1], facecolor=SOLE.light, edgecolor="none")
    )
    axes.add_patch(
        Polygon(1e3 * loads.foot.sensing_polygon[:, ::-1], facecolor="none",
                edgecolor=MUTED.light, linewidth=0.7)
    )  # fmt: skip
    x, y = 1e3 * np.unique(loads.places, axis=0).T
    axes.plot(y, x, "o", markersize=9.0, markerfacecolor="none", color=MUTED.light,
              markeredgewidth=1.0)  # fmt: skip


def _extent(loads: KnownLoads) -> tuple[FloatArray, FloatArray]:
    """The same for both figures of a shoe, so that they can be compared by eye [mm]."""
    points = np.vstack((loads.places, loads.measured, loads.corrected, loads.foot.sensing_polygon))
    return 1e3 * points.min(axis=0) - 6.0, 1e3 * points.max(axis=0) + 6.0


def _colour(index: int) -> str:
    return STEPS[index % len(STEPS)].light


def _marker(index: int) -> str:
    return MARKERS[index % len(MARKERS)]


def _mass_keys(masses: FloatArray) -> Sequence[Artist]:
    return [
        Line2D([], [], linestyle="", marker=_marker(index), markersize=3.6, color=_colour(index),
               markerfacecolor="none", label=f"{mass:g}" + (" kg" if mass == masses[-1] else ""))
        for index, mass in enumerate(masses)
    ]  # fmt: skip


def _shape_keys() -> Sequence[Artist]:
    return [
        Line2D([], [], linestyle="", marker="o", markersize=9.0, markerfacecolor="none",
               color=MUTED.light, label="hole"),
        Patch(facecolor="none", edgecolor=MUTED.light, linewidth=0.7, label="sensing polygon"),
        Patch(facecolor=SOLE.light, edgecolor="none", label="sole"),
    ]  # fmt: skip
