"""Values of several channels over a common axis, a marker each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.lines import Line2D

from shoecal_core.arrays import FloatArray
from shoecal_core.report.palette import INK, STEPS
from shoecal_core.report.svg import LINE, MARKERS, canvas, readable, y_label

PER_LINE, HEIGHT, BOTTOM = 2, 150.0, 36.0


@dataclass(frozen=True)
class ChannelTrack:
    """One channel.

    Attributes:
        label: its name.
        x: (T,) along the common axis.
        value: (T,).
        std: (T,) standard deviations; NaN where unknown; None: none are drawn, and no line.
    """

    label: str
    x: FloatArray
    value: FloatArray
    std: FloatArray | None = None


def tracks(channels: Sequence[ChannelTrack], across: str, upwards: str) -> str:
    """Markers of each channel, with a line and bars where deviations are given.

    Args:
        channels: in the order of the legend.
        across, upwards: names of the axes, with their units.
    """
    keys = [
        Line2D([], [], marker=MARKERS[index % len(MARKERS)], markersize=4.5,
               linewidth=0.0 if one.std is None else 1.0, markerfacecolor="none",
               color=STEPS[2 * index % len(STEPS)].light, label=readable(one.label, 24))
        for index, one in enumerate(channels)
    ]  # fmt: skip
    top = LINE * -(-len(keys) // PER_LINE) + 8.0
    with canvas(top + HEIGHT + BOTTOM) as page:
        page.legends(keys, PER_LINE)
        axes = page.panel(top, HEIGHT)
        if channels[0].std is None:
            axes.axhline(0.0, color=INK.light, linewidth=1.0)
        for key, one in zip(keys, channels, strict=True):
            bars = None if one.std is None else np.nan_to_num(one.std)
            axes.errorbar(one.x, one.value, yerr=bars, capsize=2.5, marker=str(key.get_marker()),
                          markersize=4.5, markerfacecolor="none", color=key.get_color(),
                          linewidth=key.get_linewidth())  # fmt: skip
        axes.margins(x=0.05, y=0.12)
        axes.locator_params(axis="y", nbins=5)
        y_label(axes, upwards)
        axes.set_xlabel(across)
        listed = "; ".join(
            f"{readable(one.label)} {', '.join(f'{value:.4g}' for value in one.value)}"
            for one in channels
        )
        return page.svg(f"{upwards} against {across}. {listed}.")
