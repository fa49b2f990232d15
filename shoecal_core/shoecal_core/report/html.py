"""A report page as one HTML file: nothing is loaded from elsewhere, nothing runs."""

from __future__ import annotations

from pathlib import Path

import jinja2
from markupsafe import Markup

from shoecal_core.files import atomic_write
from shoecal_core.report.page import Page
from shoecal_core.report.palette import variables
from shoecal_core.report.quantities import PLUS_MINUS, UNKNOWN
from shoecal_core.report.template import PAGE, STYLE

SIGNS = {"PASS": "✓", "WARN": "!", "FAIL": "✕"}
"""Beside the colours, for those who do not see them."""


def render(page: Page) -> str:
    """The page as HTML; every text is escaped, so no name can break or enter it."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["svg"] = Markup
    style = Markup(f"{variables()}\n{STYLE}")  # noqa: S704 - constants of this package
    return environment.from_string(PAGE).render(
        page=page, style=style, signs=SIGNS, plus_minus=PLUS_MINUS, unknown=UNKNOWN
    )


def write_page(path: Path, page: Page) -> None:
    """Write the page, whole or not at all.

    Raises:
        FileError: when it cannot be written.
    """
    atomic_write(path, render(page).encode(errors="replace"))
