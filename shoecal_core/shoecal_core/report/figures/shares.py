"""Shares and probabilities as a list of bars, each with its name and its number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.report.palette import RULE, Colour
from shoecal_core.report.svg import SMALL, WIDTH, area_key, canvas, readable

ROW, TOP, BAR = 33.0, 22.0, 9.0
NUMBER = 46.0
"""Room for the number, right of the bar."""


@dataclass(frozen=True)
class Share:
    """One bar.

    Attributes:
        label: above it.
        value: 0 to 1.
        colour: of it.
        kind: what the colour means; empty: nothing that needs to be said.
    """

    label: str
    value: float
    colour: Colour
    kind: str = ""


def share_bars(shares: Sequence[Share], what: str) -> str:
    """Bars from above, as long as their value.

    Args:
        shares: in the order shown.
        what: it shows, as a text for screen readers.
    """
    kinds = {share.kind: share.colour for share in shares if share.kind}
    top = TOP if kinds else 2.0
    height = ROW * len(shares)
    with canvas(top + height + 4.0) as page:
        if kinds:
            page.legend(
                [area_key(colour, kind)
                 for kind, colour in kinds.items()]
            )  # fmt: skip
        axes = page.panel(top, height, left=2.0, right=WIDTH - NUMBER)
        axes.set_axis_off()
        axes.set_xlim(0.0, 1.0)
        axes.set_ylim(height, 0.0)
        for index, share in enumerate(shares):
            middle = ROW * index + 23.0
            axes.barh(middle, 1.0, BAR, color=RULE.light, edgecolor="none")
            axes.barh(middle, min(max(share.value, 0.0), 1.0), BAR, color=share.colour.light,
                      edgecolor="none")  # fmt: skip
            page.write(2.0, top + middle - 9.0, readable(share.label, 70))
            page.write(WIDTH - 4.0, top + middle, percent(share.value), ha="right", va="center",
                       fontsize=SMALL + 1.0)  # fmt: skip
        listed = "; ".join(f"{share.label} {percent(share.value)}" for share in shares)
        return page.svg(f"{what}: {listed}.")


def percent(value: float) -> str:
    """A share for a person; a small one is not nothing, a large one not all."""
    if 0.0 < value < 0.005:
        return "< 1 %"
    if 0.995 <= value < 1.0:
        return "> 99 %"
    return f"{100.0 * value:.0f} %"
