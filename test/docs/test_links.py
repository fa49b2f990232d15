"""Links and pictures lead to files and headings that there are; nothing is fetched."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.pages import ROOT, anchors, links, pages

MADE = {
    "figures": ("conventions.svg", "demo-expected.svg", "demo-run.svg", "unload-left.svg"),
    "paper": (
        "paper-assumptions.svg",
        "paper-errors.svg",
        "paper-manual.svg",
        "paper-test.svg",
        "paper-train.svg",
    ),
    "blind": ("blind-detection.svg",),
}
"""Figures of README and docs, by what `make` calls the command that draws them."""


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    lost = []
    for line, target in links(page):
        if target.startswith(("https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists():
            lost.append(f"line {line}: {target}: no such file")
        elif anchor and anchor not in anchors(file):
            lost.append(f"line {line}: {target}: no such heading in {file.name}")
    assert not lost, "\n".join(lost)


def test_every_page_is_in_the_table_of_contents() -> None:
    index = ROOT / "docs" / "index.md"
    named = {(index.parent / target.partition("#")[0]).resolve() for _, target in links(index)}
    missing = {page for page in pages() if page.is_relative_to(index.parent)} - named - {index}
    assert not missing


def test_no_page_names_a_place_of_this_machine() -> None:
    for page in pages():
        text = page.read_text()
        assert not any(place in text for place in ("/work/", "/root/", str(Path.home()))), page


def test_every_picture_is_shown_and_every_figure_made_by_a_command() -> None:
    shown = {(page.parent / target).resolve() for page in pages() for _, target in links(page)}
    figures = set((ROOT / "docs/figures").iterdir())
    assert not {*figures, *(ROOT / "docs/images").iterdir()} - shown
    assert {file.name for file in figures} == {name for names in MADE.values() for name in names}
    makefile = (ROOT / "Makefile").read_text()
    for target in MADE:
        assert f"\n{target}: " in makefile, target


def test_sources_that_are_named_exist() -> None:
    """Modules are named by their path in the checkout or in one of the packages."""
    packages = [ROOT / name for name in ("shoecal_core", "shoecal_ros")]
    bases = [ROOT, *packages, *(package / package.name for package in packages)]
    lost = [
        f"{page.relative_to(ROOT)}: {name}"
        for page in pages()
        for name in re.findall(r"`([\w/]+/\w+\.py)`", page.read_text())
        if not name.startswith("out/") and not any((base / name).exists() for base in bases)
    ]
    assert not lost, "\n".join(lost)
