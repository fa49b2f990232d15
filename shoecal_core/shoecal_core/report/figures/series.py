"""CoP and GRF against time, and how far they are off a reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.series import Series
from shoecal_core.report.palette import MUTED, Look
from shoecal_core.report.svg import canvas, draw_line, line_key, readable, y_label

LABELS = ("CoP x (mm)", "CoP y (mm)", "GRF (N)")
HEIGHT, GAP, TOP = 164.0, 16.0, 24.0
LEAST = (4.0, 4.0, 0.8)
"""No panel shows less than this much of mm, mm, N: noise shall not look like an error."""
WILD = 3.0
"""A line further than this many spans (and values) from the last one runs out of its panel."""


@dataclass(frozen=True)
class Line:
    """One source of GRF and CoP, drawn in one look."""

    label: str
    look: Look
    series: Series


def joined(parts: Sequence[Series]) -> Series:
    """Several series in the order of time, a gap of NaN between each two."""
    if len(parts) == 1:
        return parts[0]
    ordered = sorted(parts, key=lambda part: float(part.time[0]))

    def all_of(name: str) -> FloatArray:
        """(T, ...) values of all parts."""
        pieces: list[FloatArray] = []
        for part in ordered:
            values = getattr(part, name)
            gap = values[-1:] if name == "time" else np.full_like(values[-1:], np.nan)
            pieces += [values, gap]
        return np.concatenate(pieces[:-1])

    return Series(
        all_of("time"), all_of("grf"), all_of("cop"), all_of("foot_grf"), all_of("foot_cop")
    )


def cop_and_grf(lines: Sequence[Line]) -> str:
    """CoP x, CoP y and GRF against time; later lines are drawn over earlier ones."""
    return _panels(
        [(line, _values(line.series)) for line in lines],
        LABELS,
        f"CoP x, CoP y [mm] and GRF [N] against time [s]: {_named(lines)}.",
        zero=False,
    )


def errors_in_time(lines: Sequence[Line], reference: Series) -> str:
    """How far each line is off a reference of the same instants."""
    wanted = _values(reference)
    return _panels(
        [(line, _values(line.series) - wanted) for line in lines],
        [f"Δ {label}" for label in LABELS],
        f"Errors of CoP x, CoP y [mm] and GRF [N] against time [s]: {_named(lines)}.",
        zero=True,
    )


def _values(series: Series) -> FloatArray:
    """(3, T) CoP x, CoP y [mm], GRF [N]."""
    return np.vstack((1e3 * series.cop.T, series.grf))


def _named(lines: Sequence[Line]) -> str:
    return ", ".join(readable(line.label) for line in lines)


def _panels(
    drawn: Sequence[tuple[Line, FloatArray]], labels: Sequence[str], alt: str, *, zero: bool
) -> str:
    with canvas(TOP + 3 * HEIGHT + 2 * GAP + 34.0) as page:
        page.legend([line_key(line.look, line.label) for line, _ in drawn], left=46.0)
        for row, label in enumerate(labels):
            axes = page.panel(TOP + row * (HEIGHT + GAP), HEIGHT, left=52.0)
            if zero:
                axes.axhline(0.0, color=MUTED.light, linewidth=0.8)
            for line, values in drawn:
                draw_line(axes, line.series.time, values[row], line.look)
            _frame(axes, [values[row] for _, values in drawn], LEAST[row])
            axes.set_xlim(*_bounds(np.concatenate([line.series.time for line, _ in drawn])))
            y_label(axes, label)
            axes.locator_params(axis="y", nbins=5)
            axes.tick_params(labelbottom=row == len(labels) - 1)
        axes.set_xlabel("time (s)")
        return page.svg(alt)


def _frame(axes: Axes, values: Sequence[FloatArray], least: float) -> None:
    """Show all lines, but none that runs wild at the cost of the last one."""
    low, high = _bounds(values[-1])
    room = max(WILD * (high - low), abs(low), 5.0 * least)
    lows, highs = zip(*(_bounds(value, (low, high)) for value in values), strict=True)
    bottom, top = max(min(lows), low - room), min(max(highs), high + room)
    margin = 0.06 * (top - bottom) + max(0.0, (least - (top - bottom)) / 2.0)
    axes.set_ylim(bottom - margin, top + margin)


def _bounds(values: FloatArray, otherwise: tuple[float, float] = (0.0, 1.0)) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    if not len(known):
        return otherwise
    return float(known.min()), float(known.max())
