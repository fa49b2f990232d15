"""A forecast in plain words, for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from shoecal_core.commands.tables import new_table
from shoecal_core.planning.supports.forecast import Addition, Forecast, describe_support
from shoecal_core.planning.supports.polygon_error import PolygonError


def forecast_table(rows: Sequence[tuple[str, Forecast]]) -> Table:
    """What to expect of a calibration from some double supports, a line each."""
    table = new_table("Forecast: standard errors to expect if model and readings err as set")
    table.add_column("", no_wrap=True)
    for name in ("fixed", "gains (%)", "GRF (N)", "CoP (mm)", "left CoP (mm)", "right CoP (mm)"):
        table.add_column(name, justify="right")
    for name, found in rows:
        error = found.error
        table.add_row(
            name,
            f"{found.rank} of {found.possible}",
            f"{100.0 * float(np.sqrt(np.mean(found.gain_std**2))):.1f}",
            f"{error.grf.rms:.2f}",
            *(f"{1e3 * cop.rms:.1f}" for cop in (error.cop, *error.foot_cop)),
        )
    return table


def weak_lines(found: Forecast) -> list[str]:
    """Directions that stay open, each with what is known of it."""
    return [
        f"left open: {weak.words} ("
        + ("these data say nothing of it)" if np.isinf(weak.uncertainty) else
           f"uncertain by {100.0 * weak.uncertainty:.0f} %)")
        for weak in found.weak
    ]  # fmt: skip


def addition_lines(before: Forecast, additions: Sequence[Addition]) -> list[str]:
    """What each recommended double support brings."""
    lines = []
    for addition in additions:
        after = addition.forecast
        gained = f"fixes {after.rank} instead of {before.rank} of {before.possible} directions, "
        lines.append(
            f"best to add: {describe_support(addition.support)}: "
            + (gained if after.rank > before.rank else "")
            + _cop_lines(before.error, after.error)
        )
        before = after
    return lines


def _cop_lines(before: PolygonError, after: PolygonError) -> str:
    feet = (
        f"{side} {1e3 * one.rms:.1f} -> {1e3 * other.rms:.1f}"
        for side, one, other in zip(("left", "right"), before.foot_cop, after.foot_cop, strict=True)
    )
    return f"CoP error of each foot {', '.join(feet)} mm"
