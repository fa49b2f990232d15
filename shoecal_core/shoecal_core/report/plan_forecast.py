"""What a calibration from planned motions would come to know, told before anything moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.planning.supports.forecast import Addition, Forecast
from shoecal_core.report.page import Group, KeyFigure, Section, Table
from shoecal_core.report.quantities import double_support_text, quantity
from shoecal_core.sensing.shoe import FEET


@dataclass(frozen=True)
class PlanForecast:
    """What to expect of a calibration from the planned motions.

    Attributes:
        rows: label and forecast of some of the motions, all of them first.
        additions: double supports to add, the best first.
    """

    rows: tuple[tuple[str, Forecast], ...]
    additions: tuple[Addition, ...] = ()

    @property
    def whole(self) -> Forecast:
        """Of all motions."""
        return self.rows[0][1]


TEXT = (
    "Expected of a calibration that is fitted to these motions, if model and readings err as the "
    "planner’s settings say: one standard deviation, root mean square over the sensing polygons."
)


def forecast_line(told: PlanForecast) -> str:
    """A sentence for the verdict: a motion that may be done can still tell too little."""
    found = told.whole
    if found.rank >= found.possible:
        return "A calibration from these motions would fix every direction that can be fixed."
    return (
        f"A calibration from these motions alone would fix {found.rank} of {found.possible} "
        "directions: see what to add below."
    )


def forecast_figures(told: PlanForecast) -> tuple[KeyFigure, ...]:
    """What they would fix, and how good each foot's CoP would be."""
    error = told.whole.error
    return (
        KeyFigure("would be fixed", f"{told.whole.rank} of {told.whole.possible}",
                  "directions of gains and offsets"),
        KeyFigure("expected CoP error", quantity(1e3 * error.cop.rms, "mm", 1),
                  f"both feet; the worse foot {quantity(1e3 * error.worst_foot_cop, 'mm', 1)}"),
    )  # fmt: skip


def forecast_section(told: PlanForecast) -> Section:
    """Expected errors, what stays open, and which double supports to add."""
    tables = [_errors(told.rows)]
    if told.whole.weak:
        tables.append(_open(told.whole))
    if told.additions:
        tables.append(_additions(told))
    return Section("What these motions would tell", (Group(tables=tuple(tables)),), TEXT)


def _errors(rows: Sequence[tuple[str, Forecast]]) -> Table:
    header = ("fitted to", "fixed", "gains", "GRF", "CoP, both feet",
              *(f"CoP, {foot} foot" for foot in FEET))  # fmt: skip
    return Table(
        "Expected errors",
        header,
        tuple(
            (
                label,
                f"{found.rank} of {found.possible}",
                quantity(100.0 * float(np.sqrt(np.mean(found.gain_std**2))), "%", 1),
                quantity(found.error.grf.rms, "N", 2),
                *(
                    quantity(1e3 * cop.rms, "mm", 1)
                    for cop in (found.error.cop, *found.error.foot_cop)
                ),
            )
            for label, found in rows
        ),
    )


def _open(found: Forecast) -> Table:
    rows = tuple(
        (weak.words, quantity(100.0 * weak.uncertainty, "%", 0)
         if math.isfinite(weak.uncertainty) else "nothing is told of it")
        for weak in found.weak
    )  # fmt: skip
    return Table("Left open", ("direction", "uncertain by"), rows)


def _additions(told: PlanForecast) -> Table:
    before, rows = told.whole, []
    for addition in told.additions:
        after = addition.forecast
        rows.append(
            (
                double_support_text(addition.support),
                f"{before.rank} → {after.rank} of {after.possible}",
                *(
                    f"{1e3 * one.rms:.1f} → {quantity(1e3 * other.rms, 'mm', 1)}"
                    for one, other in zip(before.error.foot_cop, after.error.foot_cop, strict=True)
                ),
            )
        )
        before = after
    return Table(
        "What to add",
        ("right foot from the left", "fixed", *(f"CoP, {foot} foot" for foot in FEET)),
        tuple(rows),
        "The best first; each brings this beside those above it.",
    )
