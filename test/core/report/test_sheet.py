"""Figures on a sheet: one SVG document that needs no page around it."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from shoecal_core.errors import ShoecalError
from shoecal_core.report.figures.named_bars import NamedBar, named_bars
from shoecal_core.report.palette import CALIBRATED
from shoecal_core.report.sheet import SheetFigure, sheet, write_sheet
from shoecal_core.report.svg import WIDTH

SVG = "{http://www.w3.org/2000/svg}"


def part(title: str, *notes: str) -> SheetFigure:
    return SheetFigure(
        title, named_bars([NamedBar("a", "3 mm", 1.0, CALIBRATED)], "Sources"), notes
    )


def read(document: str) -> ElementTree.Element:
    return ElementTree.fromstring(document)


def boxes(root: ElementTree.Element) -> list[tuple[float, float, float, float]]:
    return [
        (float(one.attrib["x"]), float(one.attrib["y"]), float(one.attrib["width"]),
         float(one.attrib["height"]))
        for one in root.iter(f"{SVG}svg") if one is not root
    ]  # fmt: skip


def test_figures_stand_side_by_side_and_below_each_other() -> None:
    root = read(sheet([[part("one"), part("two", "a note")], [part("three")]], "seen"))
    one, two, three = boxes(root)
    assert one[1] == two[1]
    assert two[0] >= one[0] + WIDTH
    assert three[1] >= one[1] + one[3]
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    for left, top, wide, high in (one, two, three):
        assert 0.0 < left < left + wide < width
        assert 0.0 < top < top + high < height
    assert {"one", "two", "three", "a note"} <= set(root.itertext())


def test_it_needs_nothing_from_elsewhere() -> None:
    """Its own ground and both sets of colours: readable in light and in dark surroundings."""
    document = sheet([[part("one")]], "seen")
    root = read(document)
    assert root.tag == f"{SVG}svg"
    assert "prefers-color-scheme:dark" in document
    used = {word.split(")")[0] for word in document.split("var(--")[1:]}
    assert all(document.count(f"--{name}:") == 2 for name in used)
    assert [one.get("class") for one in root.iter(f"{SVG}rect")].count("ground") == 1
    for one in root.iter():
        assert one.get("href", "#").startswith("#")


def test_text_cannot_break_it() -> None:
    root = read(sheet([[part('a < b & "c"', "d > e")]], 'f "g" & <h>'))
    assert 'a < b & "c"' in list(root.itertext())
    assert root.attrib["aria-label"] == 'f "g" & <h>'


def test_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "figure.svg"
    write_sheet(path, [[part("one")]], "seen")
    assert read(path.read_text()).attrib["role"] == "img"


def test_what_is_no_figure_is_refused() -> None:
    with pytest.raises(ShoecalError, match="needs a viewBox"):
        sheet([[SheetFigure("one", "<svg></svg>")]], "seen")
