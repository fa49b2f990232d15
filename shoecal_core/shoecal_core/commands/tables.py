"""Small tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from shoecal_core.calibration.evaluate import Errors
from shoecal_core.calibration.metrics import Mae


def new_table(title: str) -> Table:
    """An empty table in the one style of all commands."""
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)


def errors_table(title: str, rows: Sequence[tuple[str, Errors]]) -> Table:
    """GRF and CoP errors, combined and of each foot: MAE and its standard deviation."""
    table = new_table(title)
    table.add_column("", no_wrap=True)
    for name in ("GRF (N)", "CoP (mm)", "left CoP (mm)", "right CoP (mm)"):
        table.add_column(name, justify="right")
    for name, found in rows:
        table.add_row(
            name,
            _mae(found.grf, 1.0),
            *(_mae(mae, 1e3) for mae in (found.cop, *found.foot_cop)),
        )
    return table


def stages_rows(stages: Mapping[str, Mapping[str, Errors]]) -> list[tuple[str, Errors]]:
    """Rows `stage, set` of nested errors."""
    return [
        (f"{stage.replace('_', ' ')}, {name}", found)
        for stage, sets in stages.items()
        for name, found in sets.items()
    ]


def _mae(mae: Mae, scale: float) -> str:
    if not mae.count:
        return "-"
    return f"{mae.mean * scale:.2f} ± {mae.std * scale:.2f}"
