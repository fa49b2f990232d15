"""Colours of the reports: one meaning each, to be told apart from what they lie on."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from shoecal_core.report import palette
from shoecal_core.report.palette import CARD, COLOURS, SIZES, STEPS, Colour

LEAST_CONTRAST = 3.0
"""Of what carries meaning on its ground (WCAG 2.2, 1.4.11)."""
GROUNDS = {"rule", "paper", "card", "sole"}
LITERAL = re.compile(r"#[0-9a-fA-F]{3,8}\b(?=[\"';,)}])|\brgba?\(|\bC\d\"|\"tab:")


def luminance(code: str) -> float:
    """Relative, as WCAG defines it."""
    parts = np.array([int(code[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: str, other: str) -> float:
    """Of two colours, 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("side", ["light", "dark"])
def test_what_means_something_is_seen_on_its_ground(side: str) -> None:
    for colour in COLOURS:
        if colour.name not in GROUNDS and colour not in SIZES:
            found = contrast(getattr(colour, side), getattr(CARD, side))
            assert found >= LEAST_CONTRAST, colour.name


def test_each_meaning_has_a_colour_of_its_own() -> None:
    for values in zip(*((one.name, one.light, one.dark) for one in COLOURS), strict=True):
        assert len(set(values)) == len(COLOURS)


@pytest.mark.parametrize("order", [STEPS, SIZES])
def test_an_order_goes_away_from_its_ground(order: tuple[Colour, ...]) -> None:
    for side in ("light", "dark"):
        found = [contrast(getattr(one, side), getattr(CARD, side)) for one in order]
        assert found == sorted(found)


def test_lines_of_one_figure_differ_without_colour() -> None:
    for looks in (
        (palette.GUESS, palette.TRUTH, palette.MEASURED, palette.MODELLED),
        (palette.BEFORE, palette.AFTER, palette.ONSET),
        palette.FEET,
    ):
        assert len({(look.width, look.dashes) for look in looks}) == len(looks)


def test_no_colour_is_written_elsewhere() -> None:
    folder = Path(str(files("shoecal_core.report")))
    names = {colour.name for colour in COLOURS} | {"level", "columns", "printed"}
    for file in folder.rglob("*"):
        if file.suffix in {".py", ".css", ".html", ".js"} and file.name != "palette.py":
            text = file.read_text()
            assert not LITERAL.search(text), file
            assert set(re.findall(r"var\(--([a-z0-9]+)\)", text)) <= names, file
