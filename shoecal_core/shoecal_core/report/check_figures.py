"""Figures of the report on a session before any calibration."""

from __future__ import annotations

import numpy as np

from shoecal_core.recording.session import RunEntry
from shoecal_core.report import palette
from shoecal_core.report.check_content import CheckReport
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.page import Picture
from shoecal_core.report.palette import Look
from shoecal_core.report.quantities import quantity

FEET_LOOKS = (Look(palette.BLUE, 1.1), Look(palette.RED, 1.1))
"""Left, right."""


def raw_picture(content: CheckReport, entry: RunEntry) -> Picture:
    """Each channel of one run against time, over its own range in the whole session."""
    shoe, readings = content.session.shoe, content.runs[entry.run].readings
    faulty = {
        name for one in content.screening.left_out if one.run == entry.run for name in one.channels
    }
    rows = []
    for index, channel in enumerate(shoe.channels):
        low, high = _range(content, index)
        values = readings.value[:, index]
        known = np.isfinite(values)
        moved = (
            np.where(known, np.abs(values - np.median(values[known])), -1.0)
            if known.any()
            else None
        )
        spread = float(np.ptp(values[known])) if known.any() else float("nan")
        rows.append(
            Strip(
                label=channel.name,
                look=FEET_LOOKS[channel.foot],
                values=values,
                low=low,
                high=high,
                limits=tuple(end for end in (channel.lowest, channel.highest) if low < end < high),
                number=quantity(spread, shoe.unit, 2),
                worst=0 if moved is None else int(np.argmax(moved)),
                kept=bool(known.any()) and channel.name not in faulty,
            )
        )
    keys = [(FEET_LOOKS[0], "left"), (FEET_LOOKS[1], "right")]
    svg = strips(readings.time, rows, keys, "each strip: that channel’s range", "range here")
    caption = f"Faulty: {', '.join(sorted(faulty))}." if faulty else ""
    return Picture(f"Run {entry.run} ({entry.info.motion})", svg, caption)


def _range(content: CheckReport, index: int) -> tuple[float, float]:
    """Lowest and highest reading of a channel in all runs, a little widened."""
    every = np.concatenate([run.readings.value[:, index] for run in content.runs.values()])
    known = every[np.isfinite(every)]
    if not len(known):
        return -1.0, 1.0
    low, high = float(known.min()), float(known.max())
    margin = max(0.05 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-9)
    return low - margin, high + margin
