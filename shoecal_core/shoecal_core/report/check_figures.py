"""Figures of the report on a session before any calibration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.recording.session import RunEntry
from shoecal_core.report import palette
from shoecal_core.report.check_content import CheckReport
from shoecal_core.report.figures.strips import Strip, strips
from shoecal_core.report.page import Picture, StillStrip
from shoecal_core.report.palette import Look
from shoecal_core.report.quantities import quantity
from shoecal_core.report.scene.stills import StillInstant, instant, stills

FloatArray = NDArray[np.float64]

COUNT = 6
"""Instants of the robot shown."""
FEET_LOOKS = (Look(palette.BLUE, 1.1), Look(palette.RED, 1.1))
"""Left, right."""


def recorded_strip(content: CheckReport) -> StillStrip | None:
    """The robot in its first run; None where no run's joint angles and readings go together.

    Raises:
        NoPictureError: where nothing can draw it.
    """
    number = next((one.run for one in content.entries if one.run in content.aligned), None)
    if number is None:
        return None
    aligned = content.aligned[number]
    # Forces are not known before the calibration: the modelled CoP is shown.
    cop = aligned.states.cop[:, 0]
    shown = np.linspace(0, len(aligned.time) - 1, COUNT).round().astype(int).tolist()

    def at(sample: int) -> StillInstant:
        trail = cop[: sample + 1 : max(1, len(cop) // 150)]
        label = f"{aligned.time[sample]:.1f} s"
        unknown = np.full(2, np.nan)
        angles = aligned.joint_angles[sample]
        return instant(content.robot, label, angles, unknown, 0.0, trail)

    drawn = stills(content.robot, content.session.shoe, [[at(sample) for sample in shown]])
    return StillStrip(
        f"The robot in run {number}",
        drawn[0],
        "Posed by the recorded joint angles; limbs are as thick as their mass requires. Red "
        "line: where the model has had the CoP, seen through the feet; dashed: from the "
        "CoM down. Left leg blue, right leg orange; the lighter floor is the hull of the sensing "
        "polygons.",
    )


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
