"""Values of several channels over days, with their standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from shoecal_core.report.palette import STEPS
from shoecal_core.report.svg import canvas, readable

FloatArray = NDArray[np.float64]

MARKERS = "os^DvPX"
PER_LINE, LINE = 2, 17.0
HEIGHT, BOTTOM = 150.0, 36.0


@dataclass(frozen=True)
class ChannelTrack:
    """One channel.

    Attributes:
        label: its name.
        value: (T,) at T calibrations.
        std: (T,) standard deviations, NaN where unknown.
    """

    label: str
    value: FloatArray
    std: FloatArray


def history_figure(days: FloatArray, tracks: Sequence[ChannelTrack], label: str) -> str:
    """One line a channel, with bars of one standard deviation.

    Args:
        days: (T,) since the first calibration.
        tracks: of the channels.
        label: of the values, with their unit.
    """
    keys = [
        Line2D([], [], marker=MARKERS[index % len(MARKERS)], markersize=4.5, linewidth=1.0,
               color=STEPS[index % len(STEPS)].light, label=readable(track.label, 24))
        for index, track in enumerate(tracks)
    ]  # fmt: skip
    rows = [keys[start : start + PER_LINE] for start in range(0, len(keys), PER_LINE)]
    top = LINE * len(rows) + 8.0
    with canvas(top + HEIGHT + BOTTOM) as page:
        for index, row in enumerate(rows):
            page.legend(row, top=LINE * index)
        axes = page.panel(top, HEIGHT)
        for key, track in zip(keys, tracks, strict=True):
            axes.errorbar(days, track.value, yerr=np.nan_to_num(track.std), capsize=2.5,
                          marker=str(key.get_marker()), markersize=4.5, linewidth=1.0,
                          color=key.get_color())  # fmt: skip
        axes.margins(x=0.05, y=0.12)
        axes.set_ylabel(label)
        axes.set_xlabel("days since the first calibration")
        listed = "; ".join(
            f"{readable(one.label)} {', '.join(f'{value:.4g}' for value in one.value)}"
            for one in tracks
        )
        return page.svg(f"{label} over time. {listed}.")
