"""Lines and tables for a terminal."""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console
from rich.table import Table

from core.estimation.standing import calibration
from core.shoe import shoes
from shoecal_core.cli.tables import TEXT, new_table, of_page, print_table, reason_lines
from shoecal_core.report.page import Table as Page
from shoecal_core.shoe.wrench import ChannelParameters


def test_a_level_is_told_once_a_line() -> None:
    shoe = shoes.shoe("nao_shoe")
    plain = ChannelParameters(np.ones(len(shoe.names)), np.zeros(len(shoe.names)))
    reasons = ("FAIL: a foot slipped: hold it", "WARN: odd", "as it is")
    made = calibration(shoe, plain, verdict="FAIL", reasons=reasons)
    assert [line.plain for line in reason_lines(made)] == [
        "FAIL: a foot slipped: hold it", "WARN: odd", "FAIL: as it is"
    ]  # fmt: skip


def shown(table: Table, width: int) -> list[str]:
    """Its lines on a terminal of so many columns."""
    console = Console(file=io.StringIO(), width=width)
    print_table(console, table)
    assert isinstance(console.file, io.StringIO)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


def figures() -> Table:
    """Two rows, one of which belongs to the other."""
    table = new_table("Errors [N]")
    for name in ("", "GRF (N)", "CoP (mm)"):
        table.add_column(name)
    table.add_row("self calibration, train", "0.19 ± 0.03", "x 1.17 ± 0.29\ny 2.08 ± 0.31")
    table.add_row("  left foot", "[bold]0.05 ± 0.01[/]", "-", style="dim")
    return table


@pytest.mark.parametrize("width", [200, 60, 40, 26])
def test_no_figure_is_cut(width: int) -> None:
    lines = shown(figures(), width)
    assert max(map(len, lines)) <= width
    for figure in ("0.19 ± 0.03", "1.17 ± 0.29", "2.08 ± 0.31", "0.05 ± 0.01"):
        assert any(figure in line for line in lines)
    assert "…" not in "".join(lines)


def test_a_table_of_a_page_is_shown_with_its_values() -> None:
    page = Page("Errors [N]", ("", "CoP", "GRF"), (("left [foot]", "1.2 mm", "–"),), "note")
    assert " left [foot]   1.2 mm     –" in shown(of_page(page), 60)
    assert shown(of_page(page), 20) == ["Errors [N]", "left [foot]", "  CoP: 1.2 mm", ""]


def test_what_does_not_fit_is_shown_row_by_row() -> None:
    assert any("0.19 ± 0.03" in line and "1.17 ± 0.29" in line for line in shown(figures(), 60))
    assert shown(figures(), 40) == [
        "Errors [N]",
        "self calibration, train",
        "  GRF (N): 0.19 ± 0.03",
        "  CoP (mm): x 1.17 ± 0.29",
        "    y 2.08 ± 0.31",
        "  left foot",
        "  GRF (N): 0.05 ± 0.01",
        "",
    ]


def test_texts_wrap_before_a_table_changes_its_shape() -> None:
    table = new_table("Runs")
    table.add_column("run")
    table.add_column("motion")
    table.add_column("notes", overflow=TEXT)
    table.add_row("1", "landmarks", "one message has a stamp that goes back; it is left out")
    lines = shown(table, 60)
    assert any(line.split()[:2] == ["1", "landmarks"] for line in lines)
    assert "notes: one" in " ".join(shown(table, 30))
