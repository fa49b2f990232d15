"""Plain Markdown: tables, and the head that every generated page has."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

COMMAND = "make reference"


def page(title: str, lead: str, parts: Iterable[str]) -> str:
    """A whole page.

    Args:
        title: of the page.
        lead: what it holds, for who comes here by a search.
        parts: of Markdown.
    """
    head = f"# {title}\n\nMade by `{COMMAND}` from the code; do not edit. {lead}"
    return "\n\n".join((head, *parts)) + "\n"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; a bar inside a cell is escaped."""
    lines = [_row(head), "|" + "---|" * len(head)]
    lines += [_row([str(cell) for cell in row]) for row in rows]
    return "\n".join(lines)


def code(text: object) -> str:
    """As code; nothing where there is nothing."""
    return f"`{text}`" if str(text) else ""


def fenced(text: str, language: str = "text") -> str:
    """A block of code."""
    return f"```{language}\n{text.rstrip()}\n```"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in cells) + " |"
