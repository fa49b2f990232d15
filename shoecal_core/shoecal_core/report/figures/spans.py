"""Over which loads each channel was seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.report.palette import BLUE, INK, MUTED
from shoecal_core.report.svg import SMALL, WIDTH, canvas, readable

FloatArray = NDArray[np.float64]

ROW, TOP, BOTTOM = 20.0, 24.0, 36.0
NUMBERS = 62.0
"""Room for a span's figures, right of it."""


def spans(names: Sequence[str], ends: FloatArray, unit: str, usual: float | None = None) -> str:
    """One bar a channel, from its lowest to its highest output.

    Args:
        names: of n channels.
        ends: (2, n) lowest and highest.
        unit: of them.
        usual: drawn as a line: what each would carry if all shared alike; None: nothing.
    """
    if ends.shape != (2, len(names)):
        raise ShapeError("ends", f"(2, {len(names)})", ends.shape)
    labels = [readable(name, 24) for name in names]
    left = 14.0 + 5.6 * max(map(len, labels))
    rows = np.arange(len(names))
    height = ROW * len(names)
    with canvas(TOP + height + BOTTOM) as page:
        keys: list[Patch | Line2D] = [
            Patch(facecolor=BLUE.light, edgecolor="none", label="loads seen")
        ]
        axes = page.panel(TOP, height, left=left, right=WIDTH - NUMBERS)
        axes.grid(visible=False, axis="y")
        axes.axvline(0.0, color=INK.light, linewidth=1.0)
        if usual is not None:
            axes.axvline(usual, color=MUTED.light, linewidth=1.0, dashes=(3.0, 2.0))
            keys.append(Line2D([], [], color=MUTED.light, linewidth=1.0, dashes=(3.0, 2.0),
                               label="even share of the weight"))  # fmt: skip
        page.legend(keys)
        axes.barh(rows, ends[1] - ends[0], 0.46, left=ends[0], color=BLUE.light, edgecolor="none")
        axes.set_ylim(len(names) - 0.4, -0.6)
        axes.set_yticks(rows, labels)
        axes.tick_params(axis="y", length=0.0, labelcolor=INK.light)
        axes.use_sticky_edges = False
        axes.margins(x=0.04)
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel(f"output ({unit})")
        texts = [f"{_short(low)} to {_short(high)}" for low, high in ends.T]
        for row, text in enumerate(texts):
            page.write(
                WIDTH - 4.0, TOP + ROW * (row + 0.6) * len(names) / (len(names) + 0.2), text,
                ha="right", va="center", fontsize=SMALL, color=MUTED.light,
            )  # fmt: skip
        listed = "; ".join(f"{label} {text}" for label, text in zip(labels, texts, strict=True))
        return page.svg(f"Loads seen [{unit}]. {listed}.")


def _short(value: float) -> str:
    text = f"{value:.0f}"
    return ("0" if text == "-0" else text).replace("-", "\N{MINUS SIGN}")
