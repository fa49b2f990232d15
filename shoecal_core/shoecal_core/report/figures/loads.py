"""A shoe under known weights: its force against theirs, its CoP where they stood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.report.figures.feet import (
    Above,
    FootShape,
    around,
    draw_feet,
    from_above,
    polygon_key,
)
from shoecal_core.report.palette import CALIBRATED, INK, MUTED, SOLE, STEPS, Colour, Look
from shoecal_core.report.svg import MARKERS, area_key, canvas, line_key, marker_key, y_label

LEFT = 52.0


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
    colour = CALIBRATED.light
    with canvas(276.0) as page:
        page.legend(
            [
                line_key(Look(INK, 1.4), "weight"),
                marker_key("o", CALIBRATED, "measured, one circle a hole", 4.0),
            ],
            left=LEFT - 6.0,
        )
        axes = page.panel(24.0, 128.0, left=LEFT)
        for level in np.unique(expected):
            at = number[expected == level]
            axes.hlines(level, at[0] - 0.5, at[-1] + 0.5, color=INK.light, linewidth=1.4)
        axes.plot(number, force, "o", markersize=4.0, markerfacecolor="none", color=colour,
                  markeredgewidth=0.8)  # fmt: skip
        y_label(axes, "GRF (N)")
        axes.tick_params(labelbottom=False)
        below = page.panel(168.0, 72.0, left=LEFT)
        below.axhline(0.0, color=INK.light, linewidth=1.0)
        below.plot(number, 1e3 * (force - expected), "o", markersize=2.5, color=colour)
        y_label(below, "Δ GRF (mN)")
        below.set_xlabel("load, lightest weight first")
        for panel, height in ((axes, 128.0), (below, 72.0)):
            panel.set_xlim(0.0, len(order) + 1.0)
            panel.locator_params(axis="y", nbins=5 if height > 100.0 else 3)
        error = np.abs(force - expected)
        return page.svg(
            f"Measured force of {len(order)} loads on the {loads.foot.label} shoe against their "
            f"weights: mean absolute error {error.mean():.3f} N."
        )


def cop_under_loads(loads: KnownLoads, *, corrected: bool) -> str:
    """CoP of every load, by weight, around the hole in which it stood."""
    found = loads.corrected if corrected else loads.measured
    masses = np.unique(loads.masses)

    def draw(axes: Axes, _: float) -> None:
        """The shoe, its holes, then a marker a load."""
        draw_feet(axes, [replace(loads.foot, cells=np.zeros((0, 2)))], named=False)
        x, y = 1e3 * np.unique(loads.places, axis=0).T
        axes.plot(y, x, "o", markersize=9.0, markerfacecolor="none", color=MUTED.light)
        for index, mass in enumerate(masses):
            x, y = 1e3 * found[loads.masses == mass].T
            axes.plot(y, x, _marker(index), markersize=3.6, markerfacecolor="none",
                      markeredgewidth=0.9, color=_colour(index).light)  # fmt: skip

    # The same for both figures of a shoe, so that they can be compared by eye.
    extent = around([loads.places, loads.measured, loads.corrected, loads.foot.sensing_polygon])
    error = 1e3 * np.linalg.norm(found - loads.places, axis=1)
    alt = (
        f"CoP of {len(found)} loads on the {loads.foot.label} shoe around their holes, "
        f"{'corrected' if corrected else 'as measured'}: mean error {error.mean():.2f} mm."
    )
    holes = [marker_key("o", MUTED, "hole", 9.0), polygon_key(), area_key(SOLE, "sole")]
    return from_above([Above(*extent, draw)], [_mass_keys(masses), holes], alt, tallest=400.0)


def _colour(index: int) -> Colour:
    return STEPS[index % len(STEPS)]


def _marker(index: int) -> str:
    return MARKERS[index % len(MARKERS)]


def _mass_keys(masses: FloatArray) -> Sequence[Artist]:
    return [
        marker_key(_marker(index), _colour(index),
                   f"{mass:g}" + (" kg" if mass == masses[-1] else ""), 3.6)
        for index, mass in enumerate(masses)
    ]  # fmt: skip
