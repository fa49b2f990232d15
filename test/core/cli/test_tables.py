"""Lines and tables for a terminal."""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

from core.estimation.standing import calibration
from core.shoe import shoes
from shoecal_core.cli.prose import say
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


WORD = st.text("abcxyz0123±.−é度", min_size=1, max_size=90)
CELL = st.lists(WORD, min_size=1, max_size=12).map(" ".join)


@given(data=st.data(), width=st.integers(40, 200))
def test_every_cell_is_shown_whole(data: st.DataObject, width: int) -> None:
    columns = data.draw(st.integers(1, 6))
    row = st.lists(CELL, min_size=columns, max_size=columns)
    heads, rows = data.draw(row), data.draw(st.lists(row, min_size=1, max_size=3))
    table, texts = new_table(data.draw(CELL)), data.draw(st.sets(st.integers(0, columns - 1)))
    for number, head in enumerate(heads):
        table.add_column(head, overflow=TEXT if number in texts else "ellipsis")
    for cells in rows:
        table.add_row(*cells)
    lines = shown(table, width)
    words = {word for line in lines for word in line.split()}
    for cells in rows:
        assert {word for cell in cells for word in cell.split()} <= words
        for number, cell in enumerate(cells):
            if number and number not in texts and cell_len(cell) <= width - 4:
                assert any(cell in line for line in lines)
    longest = max(cell_len(word) for word in words)
    assert all(cell_len(line) <= max(width, longest + 6) for line in lines)


@pytest.mark.parametrize("width", [40, 60, 140])
def test_sentences_break_between_words(width: int) -> None:
    text = "  left out: 2023 of 12641 samples (16.0%), listed in out/" + "a" * 150 + "/x.csv"
    console = Console(file=io.StringIO(), width=width)
    say(console, text)
    say(console, "Next: shoecal " + "word " * 60)
    assert isinstance(console.file, io.StringIO)
    *lines, command = console.file.getvalue().splitlines()
    assert " ".join(" ".join(lines).split()) == " ".join(text.split())
    assert all(len(line) <= width for line in lines if "/" not in line)
    assert lines[0].startswith("  left")
    assert all(line.startswith("    ") for line in lines[1:])
    assert command.count("word") == 60


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
        "    GRF (N): 0.05 ± 0.01",
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
