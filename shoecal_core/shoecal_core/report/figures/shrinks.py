"""How far a gap shrinks: errors before and after, next to what noise alone would leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from shoecal_core.report.palette import CARD, INK, MUTED, Look
from shoecal_core.report.svg import SMALL, WIDTH, Canvas, canvas, readable

TOP, ROW, GAP, BOTTOM = 40.0, 24.0, 46.0, 20.0
NAMES = 72.0


@dataclass(frozen=True)
class Pair:
    """One comparison.

    Attributes:
        label: for example `measured`.
        before, after: errors in the panel's unit.
    """

    label: str
    before: float
    after: float


@dataclass(frozen=True)
class Quantity:
    """One panel.

    Attributes:
        label: with its unit.
        pairs: from above.
        floor: what noise alone would leave of the first comparison; NaN where unknown.
    """

    label: str
    pairs: tuple[Pair, ...]
    floor: float


@dataclass(frozen=True)
class Gone:
    """The share of a gap that an explanation takes away.

    Attributes:
        label: as of a `Pair`.
        fraction: 1 where all is gone.
        ci95: its 95 % interval; NaN where unknown.
    """

    label: str
    fraction: float
    ci95: tuple[float, float]


def before_and_after(
    gone: Sequence[Gone], quantities: Sequence[Quantity], looks: tuple[Look, Look]
) -> str:
    """Shares that are gone, then bars before and after, a panel a quantity."""
    heights = [2.0 * ROW * len(one.pairs) for one in quantities]
    shares = 1.2 * ROW * len(gone)
    first = TOP + (shares + GAP if gone else 0.0)
    whole = first + sum(heights) + GAP * (len(quantities) - 1) + BOTTOM + 20.0
    floors = any(np.isfinite(one.floor) for one in quantities)
    with canvas(whole) as page:
        keys: list[Patch | Line2D] = [
            Patch(facecolor=look.colour.light, edgecolor="none", label=label)
            for look, label in zip(looks, ("nothing added", "with what was found"), strict=True)
        ]
        if floors:
            keys.append(Line2D([], [], color=INK.light, linewidth=1.4, dashes=(3.0, 2.0),
                               label="noise alone"))  # fmt: skip
        page.legend(keys)
        if gone:
            _shares(page, gone, shares, looks[1])
        top = first
        for one, height in zip(quantities, heights, strict=True):
            axes = page.panel(top, height, left=NAMES, right=WIDTH - 34.0)
            page.write(0.0, top - 6.0, one.label)
            _draw(axes, one, looks)
            for index, pair in enumerate(one.pairs):
                _name(page, pair, top + ROW * (2 * index + 1))
            top += height + GAP
        listed = "; ".join(
            [f"{one.label}: {100.0 * one.fraction:.0f} % gone" for one in gone]
            + [
                f"{one.label}, {pair.label}: from {pair.before:.3g} to {pair.after:.3g}"
                for one in quantities
                for pair in one.pairs
            ]
        )
        return page.svg(f"Errors before and after. {listed}.")


def _name(page: Canvas, one: Pair | Gone, middle: float) -> None:
    page.write(NAMES - 6.0, middle, readable(one.label, 14), ha="right", va="center",
               fontsize=SMALL)  # fmt: skip


def _shares(page: Canvas, gone: Sequence[Gone], height: float, look: Look) -> None:
    """Points with their intervals from nothing to all."""
    page.write(0.0, TOP - 6.0, "share of the gap that is gone (%), 95 % interval")
    axes = page.panel(TOP, height, left=NAMES, right=WIDTH - 34.0)
    axes.grid(visible=False, axis="y")
    ends = [end for one in gone for end in (one.fraction, *one.ci95) if np.isfinite(end)]
    for index, one in enumerate(gone):
        row = index + 0.5
        low, high = (100.0 * end for end in one.ci95)
        axes.plot((low, high), (row, row), color=look.colour.light, linewidth=2.4)
        axes.plot(100.0 * one.fraction, row, "o", color=look.colour.light, markersize=6.0)
        text = f"{100.0 * one.fraction:.0f} %".replace("-", "\N{MINUS SIGN}")
        page.write(WIDTH - 4.0, TOP + height * row / len(gone), text, ha="right", va="center",
                   fontsize=SMALL)  # fmt: skip
        _name(page, one, TOP + height * row / len(gone))
    axes.axvline(100.0, color=MUTED.light, linewidth=0.8)
    axes.set_xlim(100.0 * min(0.0, *ends, 0.0), 103.0)
    axes.set_ylim(float(len(gone)), 0.0)
    axes.set_yticks([])
    axes.locator_params(axis="x", nbins=5)


def _draw(axes: Axes, one: Quantity, looks: tuple[Look, Look]) -> None:
    axes.grid(visible=False, axis="y")
    for index, pair in enumerate(one.pairs):
        for part, (value, look) in enumerate(zip((pair.before, pair.after), looks, strict=True)):
            row = 2.0 * index + 0.62 + 0.76 * part
            axes.barh(row, value, 0.6, color=look.colour.light, edgecolor="none")
            axes.annotate(f"{value:.3g}", (value, row), (4.0, 0.0), textcoords="offset points",
                          va="center", fontsize=SMALL,
                          bbox={"facecolor": CARD.light, "edgecolor": "none", "pad": 0.5}
            )  # fmt: skip
    if np.isfinite(one.floor):
        axes.plot((one.floor, one.floor), (0.1, 1.9), color=INK.light, linewidth=1.4,
                  dashes=(3.0, 2.0))  # fmt: skip
    axes.set_ylim(2.0 * len(one.pairs), 0.0)
    axes.set_xlim(left=0.0)
    axes.set_yticks([])
    axes.locator_params(axis="x", nbins=5)
    axes.tick_params(axis="x", colors=MUTED.light)
