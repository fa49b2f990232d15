"""What the data fixed: singular values against the prior."""

from __future__ import annotations

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from shoecal_core.report.palette import INK, MEASURED, MUTED
from shoecal_core.report.svg import SMALL, canvas

FloatArray = NDArray[np.float64]

SMALLEST = 1e-3
"""Anything smaller is drawn here: the data say nothing at all."""


def singular_values(values: FloatArray) -> str:
    """Singular values (p,) of the whitened Jacobian; above 1 the data say more than the prior."""
    number = np.arange(1, len(values) + 1)
    shown = np.maximum(values, SMALLEST)
    fixed = values > 1.0
    colour = MEASURED.colour.light
    with canvas(244.0) as page:
        page.legend(
            [
                Line2D([], [], linestyle="", marker="o", color=colour, label="fixed by the data"),
                Line2D([], [], linestyle="", marker="o", color=colour, markerfacecolor="none",
                       label="left to the prior"),
            ],
            left=46.0,
        )  # fmt: skip
        axes = page.panel(24.0, 182.0, left=52.0)
        axes.axhline(1.0, color=INK.light, linewidth=1.0)
        axes.annotate("1: data and prior weigh the same", (0.6, 1.0), (0.0, -4.0),
                      textcoords="offset points", va="top", fontsize=SMALL,
                      color=MUTED.light)  # fmt: skip
        axes.vlines(number, 1.0, shown, color=MUTED.light, linewidth=0.8)
        for chosen, face in ((fixed, colour), (~fixed, "none")):
            axes.plot(number[chosen], shown[chosen], "o", color=colour, markerfacecolor=face)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.minorticks_off()
        axes.set_ylim(min(0.3, float(shown.min()) / 2.0), max(3.0, float(shown.max()) * 2.0))
        axes.set_xlim(0.4, len(values) + 0.6)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=9, integer=True))
        axes.set_xlabel("direction of the parameters")
        axes.set_ylabel("singular value (1)")
        axes.yaxis.set_label_coords(-0.115, 0.5)
        return page.svg(
            f"Singular values, largest first: {', '.join(f'{value:.2g}' for value in values)}; "
            f"{int(fixed.sum())} of {len(values)} are above 1."
        )
