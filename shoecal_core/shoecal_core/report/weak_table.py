"""What data leave open, for a page and for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.planning.supports.identifiability import Identifiability
from shoecal_core.report.page import Table

MOST_UNCERTAIN = 10.0
"""Relative; what is more uncertain than that is not known at all."""


def weak_table(found: Identifiability, note: str = "") -> Table | None:
    """Directions that data leave open, those alike in one row; None without any."""
    if not found.weak:
        return None
    rows = tuple((words, known_text(each)) for words, each in found.weak_by_words.items())
    return Table("Left open by the data", ("direction", "what is known of it"), rows, note)


def weak_lines(found: Identifiability) -> list[str]:
    """The same, a line each."""
    return [
        f"not identified: {words} ({known_text(each)})"
        for words, each in found.weak_by_words.items()
    ]


def known_text(uncertainties: Sequence[float]) -> str:
    """How well directions of the same words are known."""
    count = f"{len(uncertainties)} directions, " if len(uncertainties) > 1 else ""
    known = [f"{100.0 * one:.0f}" for one in uncertainties if one <= MOST_UNCERTAIN]
    if not known:
        return f"{count}no information in these data"
    rest = " % or more" if len(known) < len(uncertainties) else " %"
    return f"{count}uncertain by {' and '.join(known)}{rest}"
