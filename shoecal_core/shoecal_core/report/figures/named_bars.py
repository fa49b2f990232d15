"""Bars of one kind in a list, each with its name and its number above it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.artist import Artist

from shoecal_core.report.palette import INK, SOLE, Colour, Look
from shoecal_core.report.svg import SMALL, WIDTH, area_key, canvas, line_key, readable

ROW, TOP, BAR = 30.0, 22.0, 8.0
BEYOND = 1.08
"""Where a bar ends that is longer than the whole."""


@dataclass(frozen=True)
class NamedBar:
    """One bar.

    Attributes:
        name: above it, on the left.
        number: above it, on the right.
        length: part of the whole; what is beyond it is as bad.
        colour: of it.
        kind: what the colour means; empty: nothing that needs to be said.
    """

    name: str
    number: str
    length: float
    colour: Colour
    kind: str = ""


def named_bars(bars: Sequence[NamedBar], what: str, limit: str = "") -> str:
    """Bars from above.

    Args:
        bars: in the order shown.
        what: they show, as a text for screen readers.
        limit: what it means that a bar reaches the whole; empty: nothing.
    """
    kinds = {bar.kind: bar.colour for bar in bars if bar.kind}
    keys: list[Artist] = [area_key(colour, kind) for kind, colour in kinds.items()]
    if limit:
        keys.append(line_key(Look(INK, 1.4), limit))
    top = TOP if keys else 2.0
    with canvas(top + ROW * len(bars) + 4.0) as page:
        if keys:
            page.legend(keys)
        axes = page.panel(top, ROW * len(bars), left=2.0, right=WIDTH - 4.0)
        axes.set_axis_off()
        axes.set_xlim(0.0, BEYOND if limit else 1.0)
        axes.set_ylim(ROW * len(bars), 0.0)
        for index, bar in enumerate(bars):
            middle = ROW * index + 21.0
            axes.barh(middle, 1.0, BAR, color=SOLE.light, edgecolor="none")
            axes.barh(middle, min(max(bar.length, 0.0), BEYOND), BAR, color=bar.colour.light,
                      edgecolor="none")  # fmt: skip
            if limit:
                axes.vlines(
                    1.0, middle - 0.6 * BAR, middle + 0.6 * BAR, color=INK.light, linewidth=1.4
                )
            over = top + middle - 7.0
            page.write(2.0, over, readable(bar.name, 60), fontsize=SMALL)
            page.write(WIDTH - 4.0, over, bar.number, ha="right", fontsize=SMALL)
        listed = "; ".join(f"{bar.name} {bar.number}" for bar in bars)
        return page.svg(f"{what}: {listed}.")
