"""A report page as one HTML file: nothing is loaded from elsewhere.

Nothing runs in it but the script of its animations, where there are any.
"""

from __future__ import annotations

import base64
import hashlib
from importlib.resources import files
from pathlib import Path

import jinja2
from markupsafe import Markup

from shoecal_core.files import atomic_write
from shoecal_core.report.page import Page
from shoecal_core.report.palette import variables
from shoecal_core.report.player import SPEEDS, USUAL_SPEED
from shoecal_core.report.quantities import PLUS_MINUS, UNKNOWN, true_minus

FEWEST_KEYS, MOST_KEYS, MOST_PRINTED_KEYS = 4, 7, 5
"""Columns of key figures on a wide page, and on paper."""
SIGNS = {"PASS": "✓", "WARN": "!", "FAIL": "✕"}
"""In addition to the colours, for those who do not see them."""


def render(page: Page) -> str:
    """The page as HTML; every text is escaped, so no name can break or enter it."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(asset), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters["svg"] = Markup
    environment.filters["true_minus"] = true_minus
    style = "\n".join(
        (variables(), asset("page.css"), asset("player.css") if page.animated else "")
    )
    script = asset("player.js")
    # Style and hash are made from files of this package.
    return environment.get_template("page.html").render(
        page=page, style=Markup(style), signs=SIGNS, plus_minus=PLUS_MINUS,  # noqa: S704
        unknown=UNKNOWN, columns=key_columns, most_printed=MOST_PRINTED_KEYS,
        script=script, script_hash=Markup(_hash(script)),  # noqa: S704
        speeds=SPEEDS, usual_speed=USUAL_SPEED,
    )  # fmt: skip


def asset(name: str) -> str:
    """Text of a file that pages are made from."""
    return files("shoecal_core.report").joinpath("assets", name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Source expression that lets this script run in a page, and nothing else."""
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"


def key_columns(count: int, most: int = MOST_KEYS) -> int:
    """Columns in which key figures fill rows of equal length, as far as can be."""
    rows = max(1, -(-count // most))
    return max(FEWEST_KEYS, -(-count // rows))


def write_page(path: Path, page: Page) -> None:
    """Write the page, whole or not at all.

    Raises:
        FileError: when it cannot be written.
    """
    atomic_write(path, render(page).encode(errors="replace"))
