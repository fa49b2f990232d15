"""One signal's residual against time, run by run, before and after an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shoecal_core.report.palette import INK, MUTED, RULE, SOLE, WARN, Look
from shoecal_core.report.quantities import size
from shoecal_core.report.svg import SMALL, WIDTH, area_key, canvas, draw_line, line_key, readable

FloatArray = NDArray[np.float64]

ROW, GAP, TOP, BOTTOM = 32.0, 6.0, 42.0, 36.0
LINE = 17.0
"""Height of a second row of the legend."""
NUMBERS = 92.0
"""Room for a row's figures, right of it."""
BAND = 2.0
"""Standard deviations of the noise that the band shows to each side."""


@dataclass(frozen=True)
class RunLine:
    """One run.

    Attributes:
        label: of it.
        time: (T,) since its start [s].
        before, after: (T,) residuals in the figure's unit; no `after` where it is empty.
        lifted: stretches in which a foot hangs [s].
        onsets: when something begins [s].
    """

    label: str
    time: FloatArray
    before: FloatArray
    after: FloatArray
    lifted: tuple[tuple[float, float], ...]
    onsets: tuple[float, ...]


def run_lines(
    rows: Sequence[RunLine], looks: tuple[Look, Look], unit: str, noise: float, name: str
) -> str:
    """A row a run, all to one scale.

    Args:
        rows: from above.
        looks: before and after.
        unit: of the residuals.
        noise: standard deviation of the signal's noise, in the unit.
        name: of the signal.
    """
    left = 14.0 + 5.4 * max(len(row.label) for row in rows)
    height = (ROW + GAP) * len(rows) - GAP
    edge = _edge(rows, noise)
    after = any(len(row.after) for row in rows)
    others = _others(rows)
    first = TOP + (LINE if others else 0.0)
    with canvas(first + height + BOTTOM) as page:
        keys = [line_key(looks[0], "nothing added")]
        keys += [line_key(looks[1], "with what was found")] if after else []
        page.legend([*keys, area_key(SOLE, "noise (±2 σ)")])
        if others:
            page.legend(others, top=LINE)
        page.write(0.0, first - 9.0, f"each row: ±{edge:.2g} {unit}", fontsize=SMALL,
                   color=MUTED.light)  # fmt: skip
        page.write(WIDTH - 4.0, first - 9.0, f"RMS ({unit})", ha="right", fontsize=SMALL,
                   color=MUTED.light)  # fmt: skip
        axes = page.panel(first, height, left=left, right=WIDTH - NUMBERS)
        _clear(axes, rows, height)
        for index, row in enumerate(rows):
            top = index * (ROW + GAP)
            _draw(axes, row, looks, top, edge, noise)
            middle = first + top + ROW / 2.0
            page.write(left - 5.0, middle, readable(row.label, 18), ha="right", va="center",
                       fontsize=SMALL)  # fmt: skip
            page.write(WIDTH - 4.0, middle, _rms_text(row), ha="right", va="center",
                       fontsize=SMALL)  # fmt: skip
        listed = "; ".join(f"{row.label} {_rms_text(row)}" for row in rows)
        return page.svg(f"Residual of {name} against time [s], RMS by run [{unit}]: {listed}.")


def _others(rows: Sequence[RunLine]) -> list[Artist]:
    keys: list[Artist] = []
    if any(row.lifted for row in rows):
        keys.append(area_key(RULE, "one foot lifted"))
    if any(row.onsets for row in rows):
        keys.append(line_key(Look(WARN, 1.6, (2.0, 1.0)), "something begins"))
    return keys


def _edge(rows: Sequence[RunLine], noise: float) -> float:
    """What the rows show to each side: nearly all, and no less than the noise's band."""
    every = np.abs(np.concatenate([np.concatenate((row.before, row.after)) for row in rows]))
    known = every[np.isfinite(every)]
    return max(float(np.quantile(known, 0.995)) if len(known) else 0.0, 1.6 * BAND * noise, 1e-12)


def _clear(axes: Axes, rows: Sequence[RunLine], height: float) -> None:
    # One panel for all: a panel each takes ten times as long to draw.
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(axis="x", length=3.0)
    axes.set_ylim(height, 0.0)
    axes.set_xlim(0.0, max(float(row.time[-1]) for row in rows))
    axes.set_yticks([])
    axes.set_xlabel("time since the run's start (s)")


def _draw(
    axes: Axes, row: RunLine, looks: tuple[Look, Look], top: float, edge: float, noise: float
) -> None:
    middle, scale = top + ROW / 2.0, ROW / 2.0 / edge
    ends = (float(row.time[0]), float(row.time[-1]))
    for start, stop in row.lifted:
        axes.fill_between((start, stop), top, top + ROW, color=RULE.light, linewidth=0.0)
    band = BAND * noise * scale
    axes.fill_between(ends, middle - band, middle + band, color=SOLE.light, linewidth=0.0)
    axes.plot(ends, (middle, middle), color=MUTED.light, linewidth=0.6)
    for values, look in zip((row.before, row.after), looks, strict=True):
        if len(values):
            inside = np.where(np.isnan(values), np.nan, np.clip(values, -edge, edge))
            draw_line(axes, row.time, middle - scale * inside, look)
    for onset in row.onsets:
        axes.plot((onset, onset), (top - GAP / 2.0, top + ROW + GAP / 2.0), color=WARN.light,
                  linewidth=1.6, dashes=(2.0, 1.0), clip_on=False)  # fmt: skip
        axes.annotate(f"{onset:.1f} s", (onset, top), (3.0, -6.0), textcoords="offset points",
                      fontsize=SMALL, color=INK.light)  # fmt: skip


def _rms_text(row: RunLine) -> str:
    """Before, and after where there is one."""
    texts = []
    for values in (row.before, row.after):
        known = values[np.isfinite(values)]
        if len(known):
            texts.append(size(float(np.sqrt(np.mean(known**2))), "1"))
    return " → ".join(texts) or "–"
