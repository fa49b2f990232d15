"""Several figures on one sheet: an SVG file that stands by itself, for pages that are not ours.

It brings its own colours, light and dark, and its own ground, so that it can be read wherever
it is shown.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.report.palette import variables
from shoecal_core.report.svg import WIDTH

MARGIN, GAP, TITLE, LINE = 14.0, 26.0, 22.0, 15.0
STYLE = (
    'text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}'
    ".ground{fill:var(--card)}.title{font-size:12px;font-weight:600;fill:var(--ink)}"
    ".note{font-size:10px;fill:var(--muted)}"
    "svg svg{overflow:visible;stroke-linejoin:round;stroke-linecap:butt}"
)
_VIEW_BOX = re.compile(r'viewBox="0 0 ([\d.]+) ([\d.]+)"')


@dataclass(frozen=True)
class SheetFigure:
    """One figure of a sheet.

    Attributes:
        title: above it.
        svg: an `<svg>` element of the reports.
        notes: lines below it.
    """

    title: str
    svg: str
    notes: tuple[str, ...] = ()

    @property
    def height(self) -> float:
        """Of figure, title and notes, in units."""
        return TITLE + _size(self.svg)[1] + LINE * len(self.notes)


def sheet(rows: Sequence[Sequence[SheetFigure]], alt: str) -> str:
    """Rows of figures as one SVG document.

    Args:
        rows: from above; every figure is one column wide.
        alt: what is to be seen, for those who do not see it.
    """
    columns = max(map(len, rows))
    width = 2 * MARGIN + columns * WIDTH + (columns - 1) * GAP
    drawn, top = [], MARGIN
    for row in rows:
        for column, part in enumerate(row):
            drawn.append(_placed(part, MARGIN + column * (WIDTH + GAP), top))
        top += max(part.height for part in row) + GAP
    height = top - GAP + MARGIN
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}" role="img" aria-label={quoteattr(alt)}>\n'
        f"<style>{variables()}\n{STYLE}</style>\n"
        f'<rect class="ground" width="100%" height="100%"/>\n{"".join(drawn)}</svg>\n'
    )


def write_sheet(path: Path, rows: Sequence[Sequence[SheetFigure]], alt: str) -> None:
    """Write the sheet, whole or not at all.

    Raises:
        FileError: when it cannot be written.
    """
    atomic_write(path, sheet(rows, alt))


def _placed(part: SheetFigure, left: float, top: float) -> str:
    width, height = _size(part.svg)
    figure = part.svg.replace(
        "<svg ", f'<svg x="{left:g}" y="{top + TITLE:g}" width="{width:g}" height="{height:g}" ', 1
    )
    bottom = top + TITLE + height
    notes = "".join(
        f'<text class="note" x="{left:g}" y="{bottom + LINE * (index + 0.8):g}">'
        f"{escape(note)}</text>\n"
        for index, note in enumerate(part.notes)
    )
    title = f'<text class="title" x="{left:g}" y="{top + 12:g}">{escape(part.title)}</text>'
    return f"{title}\n{figure}\n{notes}"


def _size(svg: str) -> tuple[float, float]:
    found = _VIEW_BOX.search(svg)
    if found is None:
        raise ShoecalError("a figure on a sheet needs a viewBox that begins at 0 0")
    return float(found[1]), float(found[2])
