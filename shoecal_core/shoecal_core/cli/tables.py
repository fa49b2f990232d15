"""Small tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, OverflowMethod
from rich.markup import escape
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.series import Errors, Mae
from shoecal_core.report.page import Table as PageTable
from shoecal_core.report.quantities import UNKNOWN
from shoecal_core.screening.verdict import split_reason
from shoecal_core.shoe.shoe import FEET

LEVELS = {"PASS": "bold green", "WARN": "bold yellow", "FAIL": "bold red"}
"""How verdicts look on a terminal."""
TEXT: OverflowMethod = "fold"
"""Overflow of columns that hold texts, which may wrap."""
TEXT_WIDTH = 24
"""Columns of a terminal that such a column takes at least, where its texts are longer."""
EMPTY = ("-", UNKNOWN)
"""Cells that say nothing: left out where a table is shown row by row."""
UNBOUNDED = 10_000
WRITTEN = {"grf": ("GRF", "N", 3), "cop": ("CoP", "mm", 2)}
"""Quantities, their units and decimals of a small difference, by their names in result files."""


def verdict_line(verdict: str, text: str) -> Text:
    """A verdict and what it is for; on a terminal in the colour of its kind."""
    return Text.assemble((verdict, LEVELS[verdict]), f": {text}")


def reason_lines(calibration: Calibration) -> list[Text]:
    """Why its verdict is what it is, a line a reason, each with its own level."""
    reasons = (split_reason(one, calibration.verdict) for one in calibration.reasons)
    return [verdict_line(level, text) for level, text in reasons]


def new_table(title: str) -> Table:
    """An empty table in the one style of all commands."""
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)


def of_page(page: PageTable) -> Table:
    """A table of the reports, which a terminal shows with the same values, without its note."""
    table = new_table(page.title)
    for number, heading in enumerate(page.header):
        table.add_column(heading, justify="right" if number else "left", no_wrap=True)
    for row in page.rows:
        table.add_row(*map(escape, row))
    return table


def print_table(console: Console, table: Table) -> None:
    """Print a table, or what it holds row by row where the terminal is too narrow for it.

    No figure is ever cut or broken: only columns with the overflow TEXT wrap.
    """
    for column in table.columns:
        column.no_wrap = column.overflow != TEXT
    if _needed(console, table) <= console.width:
        console.print(table)
        return
    if table.title:
        console.print(table.title, style="italic", markup=False)
    names = [str(column.header) for column in table.columns]
    cells = zip(*(column.cells for column in table.columns), strict=True)
    for row, texts in zip(table.rows, cells, strict=True):
        for number, (name, text) in enumerate(zip(names, texts, strict=True)):
            if number and text in EMPTY:
                continue
            if number == 0:
                line = Text.from_markup(f"{name} {text}" if name else str(text))
            else:
                line = Text.from_markup(f"{name}: {text}".replace("\n", "\n  "))
            console.print(Padding(line, (0, 0, 0, 2 * min(number, 1))), style=row.style or "")
    console.print()


def _needed(console: Console, table: Table) -> int:
    """Columns of a terminal in which nothing is cut."""
    unbounded = console.options.update(max_width=UNBOUNDED)
    width = Measurement.get(console, unbounded, table).maximum
    for column in table.columns:
        if column.overflow == TEXT:
            lines = [line for cell in column.cells for line in str(cell).splitlines()]
            longest = max(map(cell_len, [str(column.header), *lines]))
            width -= max(0, longest - TEXT_WIDTH)
    return width


def errors_table(title: str, rows: Sequence[tuple[str, Errors]]) -> Table:
    """GRF and CoP errors: MAE and its standard deviation; each foot below both together.

    A foot that nothing is known of has no line.
    """
    table = new_table(title)
    table.add_column("", no_wrap=True)
    for name in WRITTEN:
        table.add_column(_heading(name), justify="right", no_wrap=True)
    for label, found in rows:
        table.add_row(label, _mae(found.grf, 1.0), _mae(found.cop, 1e3))
        for foot, grf, cop in zip(FEET, found.foot_grf, found.foot_cop, strict=True):
            if grf.count or cop.count:
                table.add_row(f"  {foot} foot", _mae(grf, 1.0), _mae(cop, 1e3), style="dim")
    return table


def left_out_lines(rows: Sequence[tuple[str, Errors]], *, feet: bool = True) -> list[str]:
    """Where samples had to be left out of a figure, so that it is not taken for the whole.

    Args:
        rows: of a table of errors.
        feet: of each foot's figures, too; a model knows these at times only.
    """
    return [
        f"{label}: {_heading(name)} counts {mae.count} of {mae.count + mae.left_out} samples; in "
        "the others the foot was not loaded, or nothing is known of it"
        for label, found in rows
        for name, (mae, _, _) in found.figures().items()
        if mae.count and mae.left_out and (feet or name in WRITTEN)
    ]


def _heading(name: str) -> str:
    foot, _, what = name.rpartition("_")
    quantity, unit, _ = WRITTEN[what]
    return f"{foot} {quantity} ({unit})".strip()


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
