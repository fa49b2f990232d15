"""Small tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, OverflowMethod
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from shoecal_core.cli.prose import UNBOUNDED, say
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
PIPE_WIDTH = 140
"""Columns of a table that is piped or written to a file."""
BETWEEN = 3
"""Columns that a table takes for each of its own, next to its text."""
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
    return Table(title=title, box=SIMPLE_HEAD, pad_edge=False)


def of_page(page: PageTable) -> Table:
    """A table of the reports, which a terminal shows with the same values, without its note."""
    table = new_table(page.title)
    for number, heading in enumerate(page.header):
        table.add_column(heading, justify="right" if number else "left")
    for row in page.rows:
        table.add_row(*map(escape, row))
    return table


def print_table(console: Console, table: Table) -> None:
    """Print a table, or what it holds row by row where the terminal is too narrow for it.

    No figure is ever cut or broken: only columns with the overflow TEXT wrap, between words.
    """
    title, table.title = str(table.title or ""), None
    if title:
        say(console, Text(title, "italic"))
    # Where lines have no bound, texts in columns have one.
    width = PIPE_WIDTH if console.width >= UNBOUNDED else console.width
    if _fits(table, width):
        console.print(table, soft_wrap=True)
    else:
        _print_rows(console, table)
        console.print()


def _print_rows(console: Console, table: Table) -> None:
    """A line a cell, with the heading of its column, below the first cell of its row."""
    names = [str(column.header) for column in table.columns]
    cells = zip(*(column.cells for column in table.columns), strict=True)
    for row, texts in zip(table.rows, cells, strict=True):
        first, *values = (Text.from_markup(str(text)) for text in texts)
        style, margin = row.style or "", " " * (2 + first.cell_len - cell_len(first.plain.lstrip()))
        say(console, Text(f"{names[0]} " if names[0] else "", style).append_text(first))
        for column, name, value in zip(table.columns[1:], names[1:], values, strict=True):
            if value.plain not in EMPTY:
                head, lines = Text(f"{margin}{name}: ", style), value.split("\n")
                fits = head.cell_len + lines[0].cell_len <= console.width
                if fits or column.overflow == TEXT:
                    head.append_text(lines.pop(0))
                say(console, head)
                for line in lines:
                    say(console, Text(f"{margin}  ").append_text(line))


def _fits(table: Table, width: int) -> bool:
    """Whether nothing is cut in so many columns of a terminal; columns of text take what is left.

    The table is given the widths of its columns.
    """
    needed, wanted = [], []
    for column in table.columns:
        lines = [
            line for cell in (column.header, *column.cells)
            for line in Text.from_markup(str(cell)).plain.splitlines()
        ]  # fmt: skip
        longest = max(map(cell_len, lines), default=0)
        word = max((cell_len(word) for line in lines for word in line.split()), default=0)
        wraps = column.overflow == TEXT
        needed.append(min(longest, max(TEXT_WIDTH, word)) if wraps else longest)
        wanted.append(longest)
    left = width - sum(needed) - BETWEEN * len(needed)
    for column, least, most in zip(table.columns, needed, wanted, strict=True):
        more = max(0, min(left, most - least))
        column.width, column.no_wrap = least + more, least + more >= most
        left -= more
    return left >= 0


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
