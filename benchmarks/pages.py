"""Pages that several benchmarks write: performance.md and trust.md of docs/evidence.

Each benchmark owns one section of a page, between `<!-- name -->` and `<!-- /name -->`, and one
key of the file; it replaces its own and leaves the others' as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import bench_json
from shoecal_core.files import atomic_write

ROOT = Path(__file__).resolve().parents[1]
PERFORMANCE = ROOT / "docs" / "evidence" / "performance.md"
PERFORMANCE_HEAD = """\
# Speed and memory

Each section names its command; `make bench` runs them all. The figures depend on the machine:
compare ratios.
"""
PAGE = ROOT / "docs" / "evidence" / "trust.md"
FIGURES = ROOT / "out" / "trust.json"
HEAD = """\
# Accuracy and uncertainty of a calibration

Everything here is simulated; each section names its command.
"""


def write_trust(
    name: str, body: str, figures: Mapping[str, object], page: Path = PAGE, file: Path = FIGURES
) -> None:
    """Write one benchmark's section and figures.

    Args:
        name: of the section, and key of the figures.
        body: Markdown, with its own heading.
        figures: for the file.
        page: Markdown page.
        file: JSON.
    """
    bench_json.record(name, figures, file)
    write_section(name, body, page, HEAD)


def write_performance(name: str, body: str, page: Path = PERFORMANCE) -> None:
    """Write one benchmark's section, Markdown with its own heading, on time and memory."""
    write_section(name, body, page, PERFORMANCE_HEAD)


def write_section(name: str, body: str, page: Path, head: str) -> None:
    """Write a section in its place, or behind the others; a new page begins with `head`."""
    text = page.read_text() if page.is_file() else head
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, found, rest = text.partition(begin)
    after = rest.partition(end)[2] if found else "\n"
    atomic_write(page, f"{before.rstrip()}\n\n{begin}\n{body.strip()}\n{end}{after}")


def table(rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; the first row is its head."""
    lines = [list(rows[0]), ["---"] * len(rows[0]), *(list(row) for row in rows[1:])]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
