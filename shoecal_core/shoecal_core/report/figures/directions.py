"""Identified directions: singular values of what they say of the parameters."""

from __future__ import annotations

import numpy as np
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from shoecal_core.report.palette import INK, MEASURED, MUTED
from shoecal_core.report.svg import SMALL, canvas

FloatArray = NDArray[np.float64]

SMALLEST = 1e-2
"""Anything smaller is drawn here: the data say nothing at all."""


def singular_values(values: FloatArray, limit: float = 1.0) -> str:
    """Bars of singular values (p,), largest first, from the limit of identified ones.

    Args:
        values: of the whitened Jacobian: one over a direction's relative uncertainty.
        limit: above it a direction counts as identified.
    """
    number = np.arange(1, len(values) + 1)
    shown = np.maximum(values, SMALLEST * limit)
    fixed = values > limit
    colour = MEASURED.colour.light
    with canvas(244.0) as page:
        keys = [Patch(facecolor=colour, edgecolor=colour, label="identified")]
        if not fixed.all():
            keys.append(Patch(facecolor="none", edgecolor=colour, label="not identified"))
        page.legend(keys, left=46.0)
        axes = page.panel(24.0, 182.0, left=52.0)
        axes.grid(visible=False, axis="x")
        axes.set_yscale("log")
        for chosen, face in ((fixed, colour), (~fixed, "none")):
            # Bars on a logarithmic axis grow from the limit, up or down.
            axes.bar(number[chosen], (shown - limit)[chosen], 0.62, bottom=limit, facecolor=face,
                     edgecolor=colour, linewidth=1.2)  # fmt: skip
        axes.axhline(limit, color=INK.light, linewidth=1.2)
        axes.annotate("identified above, not identified below", (0.6, limit), (0.0, -4.0),
                      textcoords="offset points", va="top", fontsize=SMALL,
                      color=MUTED.light)  # fmt: skip
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.minorticks_off()
        axes.set_ylim(
            min(0.3 * limit, float(shown.min()) / 2.0), max(3.0 * limit, float(shown.max()) * 2.0)
        )
        axes.set_xlim(0.2, len(values) + 0.8)
        axes.xaxis.set_major_locator(MaxNLocator(nbins=9, integer=True))
        axes.set_xlabel("direction of the parameters")
        axes.set_ylabel("singular value (1)")
        axes.yaxis.set_label_coords(-0.115, 0.5)
        return page.svg(
            f"Singular values, largest first: {', '.join(f'{value:.2g}' for value in values)}; "
            f"{int(fixed.sum())} of {len(values)} are above {limit:g}."
        )
