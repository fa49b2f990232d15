"""How far the CoP is off, place by place, as arrows on the feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from shoecal_core.arrays import FloatArray
from shoecal_core.report.figures.feet import (
    LEFT,
    Above,
    FootShape,
    around,
    draw_feet,
    draw_outline,
    from_above,
    shape_keys,
)
from shoecal_core.report.palette import INK, MUTED, PLAIN, SOLE, Look
from shoecal_core.report.svg import SMALL, Canvas, line_key, readable

LONGEST_MM = 20.0
"""Of the arrows that are drawn, but for the longest in twenty."""
LONGEST_OF_NOISE_MM = 5.0
BUBBLE_MM = 7.0
"""Diameter of the bubble of the largest force."""


@dataclass(frozen=True)
class Field:
    """A residual over places, k squares of a grid.

    Attributes:
        places: (k, 2) middle of the samples in each square [m].
        arrows: (k, 2) mean CoP residual there [m].
        force: (k,) mean GRF residual there [N].
    """

    places: FloatArray
    arrows: FloatArray
    force: FloatArray


@dataclass(frozen=True)
class FieldPanel:
    """A field with the feet below it, in one frame.

    Attributes:
        feet: filled.
        field: over them.
        title: above them.
        thin: (k, 2) further outlines [m].
        shares: text at each cell (place, text).
    """

    feet: Sequence[FootShape]
    field: Field
    title: str
    thin: Sequence[FloatArray] = ()
    shares: Sequence[tuple[FloatArray, str]] = ()


def magnification(fields: Sequence[Field], noise: float) -> float:
    """How many times longer than true arrows are drawn; the same for all figures of one kind.

    Args:
        fields: to be drawn.
        noise: standard deviation of one sample [m]; it is never blown up to a long arrow.
    """
    lengths = np.concatenate([np.linalg.norm(one.arrows, axis=1) for one in fields])
    if not len(lengths) or not lengths.any():
        return 1.0
    most = 1e-3 * LONGEST_OF_NOISE_MM / noise if noise > 0.0 else np.inf
    exact = min(1e-3 * LONGEST_MM / float(np.quantile(lengths, 0.95)), most)
    step = 10.0 ** np.floor(np.log10(exact))
    return float(step * max(factor for factor in (1.0, 2.0, 5.0) if factor * step <= exact))


def residual_fields(
    panels: Sequence[FieldPanel], look: Look, times: float, largest: float = 0.0
) -> str:
    """Arrows on feet seen from above, with bubbles of the force error and shares at cells.

    Args:
        panels: from the left.
        look: of the arrows.
        times: see `magnification`.
        largest: force error of the largest bubble; 0: without bubbles [N].
    """

    def band(page: Canvas, top: float) -> None:
        """What the bubbles mean."""
        page.write(LEFT, top + 8.0, f"largest circle: GRF off by {largest:.2g} N; "
                   "filled: too much, empty: too little", fontsize=SMALL)  # fmt: skip

    drawn = [
        Above(*around([*(part for foot in one.feet for part in (foot.outline, foot.cells)),
                       *one.thin]),
              partial(_draw, one, look, times, largest), one.title)
        for one in panels
    ]  # fmt: skip
    listed = " ".join(f"{one.title}: {_summary(one.field)}" for one in panels)
    return from_above(
        drawn,
        [[line_key(look, f"CoP error, {times:g} × as long")], shape_keys()],
        f"CoP and GRF error seen from above. {listed}",
        band=band if largest > 0.0 else None,
    )


def _draw(
    one: FieldPanel, look: Look, times: float, largest: float, axes: Axes, scale: float
) -> None:
    """Feet, bubbles, arrows, shares."""
    draw_feet(axes, one.feet, named=False)
    for outline in one.thin:
        draw_outline(axes, outline, Look(MUTED, 0.5))
    if largest > 0.0:
        _bubbles(axes, one.field, largest, scale)
    _quiver(axes, one.field, look, times)
    for place, text in one.shares:
        _share(axes, place, text)


def _quiver(axes: Axes, field: Field, look: Look, times: float) -> None:
    if not len(field.places):
        return
    x, y = 1e3 * field.places.T
    u, v = 1e3 * times * field.arrows.T
    axes.quiver(y, x, v, u, angles="xy", scale_units="xy", scale=1.0, color=look.colour.light,
                width=1.6, units="dots", headwidth=3.6, headlength=4.0, headaxislength=3.6,
                minlength=0.5, zorder=3.0)  # fmt: skip


def _bubbles(axes: Axes, field: Field, largest: float, scale: float) -> None:
    """Areas are in proportion to forces."""
    x, y = 1e3 * field.places.T
    sizes = np.abs(field.force) / largest * (BUBBLE_MM * scale) ** 2
    for chosen, face in ((field.force >= 0.0, PLAIN.light), (field.force < 0.0, "none")):
        axes.scatter(y[chosen], x[chosen], s=sizes[chosen], facecolor=face, edgecolor=PLAIN.light,
                     linewidth=0.7, alpha=0.55, zorder=2.0)  # fmt: skip


def _share(axes: Axes, place: FloatArray, text: str) -> None:
    x, y = 1e3 * place
    axes.annotate(readable(text, 12), (y, x), (0.0, 8.0), textcoords="offset points", ha="center",
                  va="bottom", fontsize=SMALL, color=INK.light, zorder=4.0,
                  bbox={"facecolor": SOLE.light, "edgecolor": "none", "pad": 1.0})  # fmt: skip


def _summary(field: Field) -> str:
    lengths = 1e3 * np.linalg.norm(field.arrows, axis=1)
    if not len(lengths):
        return "No sample."
    return (
        f"{len(lengths)} places, {lengths.mean():.2f} mm on average, {lengths.max():.2f} mm "
        "at most."
    )
