"""Expected error of the CoP, place by place, as a map seen from above."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.report.figures.feet import (
    LEFT,
    RIGHT,
    Above,
    FootShape,
    around,
    draw_feet,
    from_above,
    shape_keys,
)
from shoecal_core.report.palette import INK, SIZES
from shoecal_core.report.svg import SMALL, WIDTH, Canvas, readable

RASTER = 61
"""Points of the drawn map along each axis."""
LEAST_SPAN_MM = 0.5
"""Errors that differ by less have one colour."""


@dataclass(frozen=True)
class ErrorMap:
    """Errors over one polygon.

    Attributes:
        label: of the map.
        feet: the soles below it, in its frame.
        places: (p, 2) of the CoP [m]; NaN where there is none.
        length: (p,) expected length of its error there [m].
    """

    label: str
    feet: tuple[FootShape, ...]
    places: FloatArray
    length: FloatArray

    def __post_init__(self) -> None:
        if self.places.shape != (len(self.length), 2):
            raise ShapeError("map.places", f"({len(self.length)}, 2)", self.places.shape)

    @property
    def known(self) -> FloatArray:
        """(k, 3) place and length where both are finite [mm]."""
        rows = 1e3 * np.column_stack((self.places, self.length))
        finite: FloatArray = rows[np.isfinite(rows).all(axis=1)]
        return finite


def common_levels(maps: Sequence[ErrorMap]) -> FloatArray:
    """(k,) 2 to 7 round borders of the colours [mm], so that all maps can be compared."""
    lengths = np.concatenate([one.known[:, 2] for one in maps])
    if not len(lengths):
        return np.array([0.0, 1.0])
    low, high = float(lengths.min()), float(lengths.max())
    middle, half = (low + high) / 2.0, max(high - low, LEAST_SPAN_MM) / 2.0
    low, high = max(0.0, middle - half), middle + half
    for most in range(len(SIZES), 1, -1):
        ticks = np.asarray(MaxNLocator(nbins=most, min_n_ticks=2).tick_values(low, high))
        # One more than needed may stand at either end.
        first = max(0, int(np.searchsorted(ticks, low, side="right")) - 1)
        last = int(np.searchsorted(ticks, high, side="left"))
        levels: FloatArray = ticks[first : last + 1]
        if len(levels) <= len(SIZES) + 1:
            break
    return levels


def error_map(maps: Sequence[ErrorMap], levels: FloatArray) -> str:
    """Maps side by side in the same colours and to the same scale.

    Args:
        maps: one a panel.
        levels: (c,) borders of the colours; see `common_levels` [mm].
    """
    panels = [Above(*_extent(one), partial(_draw, one, levels), one.label) for one in maps]
    alt = f"Expected error of the CoP seen from above. {_summary(maps)}."
    return from_above(panels, [shape_keys()], alt, tallest=250.0, band=partial(_colour_bar, levels))


def _summary(maps: Sequence[ErrorMap]) -> str:
    parts = []
    for one in maps:
        lengths = one.known[:, 2]
        found = f"{lengths.min():.1f} to {lengths.max():.1f} mm" if len(lengths) else "none known"
        parts.append(f"{readable(one.label, 36)}: {found}")
    return "; ".join(parts)


def _extent(one: ErrorMap) -> tuple[FloatArray, FloatArray]:
    soles = [points for foot in one.feet for points in (foot.outline, foot.cells)]
    return around([*soles, 1e-3 * one.known[:, :2]])


def _colour_bar(levels: FloatArray, page: Canvas, top: float) -> None:
    """What the colours mean."""
    colours = _colours(levels)
    page.write(LEFT, top + 6.0, "CoP error (mm)", fontsize=SMALL, va="center")
    bar = page.panel(top + 1.0, 10.0, left=LEFT + 88.0, right=WIDTH - RIGHT - 10.0)
    for index, colour in enumerate(colours):
        bar.axvspan(index, index + 1, facecolor=colour, edgecolor="none", linewidth=0.0)
    bar.set_xlim(0.0, len(colours))
    bar.set_ylim(0.0, 1.0)
    bar.set_yticks([])
    bar.set_xticks(range(len(levels)), [f"{level:.4g}" for level in levels])
    bar.tick_params(axis="x", length=0.0, pad=2.0, labelcolor=INK.light)
    bar.grid(visible=False)
    bar.spines[:].set_visible(False)


def _colours(levels: FloatArray) -> list[str]:
    """One for each stretch between two levels; few stretches keep well apart."""
    count = len(levels) - 1
    chosen = np.linspace(0.0, len(SIZES) - 1.0, count + 2).round().astype(int)[1:-1]
    if count > len(SIZES) - 2:
        chosen = np.arange(count)
    return [SIZES[index].light for index in chosen]


def _draw(one: ErrorMap, levels: FloatArray, axes: Axes, _: float) -> None:
    if len(one.known):
        x, y, length = _raster(one.known)
        axes.contourf(
            y, x, np.clip(length, levels[0], levels[-1]), levels=levels, colors=_colours(levels)
        )
        hull = shapely.MultiPoint(one.known[:, 1::-1]).convex_hull
        clip = Polygon(shapely.get_coordinates(hull), transform=axes.transData)
        # One artist since Matplotlib 3.8, one a level before.
        for drawn in axes.collections:
            drawn.set_clip_path(clip)
    draw_feet(axes, one.feet, named=False)


def _raster(known: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Axes (r,) and lengths (r, r) over the box around places and lengths (k, 3) [mm].

    As long as all feet are loaded, the square of the length is a polynomial of the place: readings
    and the slopes of the CoP are both linear in it. Few places therefore determine it.
    """
    low, high = known[:, :2].min(axis=0), known[:, :2].max(axis=0)
    half = np.maximum((high - low) / 2.0, 1e-9)
    degree = next((d for d in (4, 2, 1) if len(known) > (d + 1) * (d + 2)), 0)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]

    def terms(x: FloatArray, y: FloatArray) -> FloatArray:
        """(..., p) monomials of places (...)."""
        return np.stack([x**i * y**j for i, j in powers], axis=-1)

    scaled = (known[:, :2] - low) / half - 1.0
    factors, *_ = np.linalg.lstsq(terms(*scaled.T), known[:, 2] ** 2, rcond=None)
    unit = np.linspace(-1.0, 1.0, RASTER)
    squares = terms(*np.meshgrid(unit, unit, indexing="ij")) @ factors
    lengths: FloatArray = np.sqrt(np.clip(squares, 0.0, None))
    x, y = low[:, None] + half[:, None] * (unit + 1.0)[None, :]
    return x, y, lengths
