"""docs/performance.md: one marked section a benchmark, each written by its own command."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from shoecal_core.files import atomic_write

PATH = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
HEAD = """\
# How fast it is, and how much memory it takes

Every section is made by the command that it names; `make bench` runs them all. The figures are
those of the machine they were last made on: what counts is how they compare.
"""


def write_section(name: str, title: str, command: str, body: str, path: Path = PATH) -> None:
    """Write a section anew in its place, or behind the others.

    Args:
        name: by which the section is found again.
        title: its heading.
        command: that measures it.
        body: Markdown.
        path: of the page.
    """
    text = path.read_text() if path.is_file() else HEAD
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->\n"
    section = f"{begin}## {title}\n\nMade by `{command}`.\n\n{body.strip()}\n{end}"
    before, found, rest = text.partition(begin)
    after = rest.partition(end)[2] if found else ""
    atomic_write(path, f"{before.rstrip()}\n\n{section}{after}")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
