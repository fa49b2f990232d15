"""docs/trust.md and out/trust.json: what several benchmarks say of a calibration's trust.

Each benchmark owns one section of the page, between `<!-- name -->` and `<!-- /name -->`, and one
key of the file; it replaces its own and leaves the others' as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import bench_json
from shoecal_core.files import atomic_write

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "trust.md"
FIGURES = ROOT / "out" / "trust.json"
HEAD = """\
# How far a calibration can be trusted

Everything here is simulated, and measured by the commands that each section names.
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
    text = page.read_text() if page.is_file() else HEAD
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, found, rest = text.partition(begin)
    after = rest.partition(end)[2] if found else "\n"
    atomic_write(page, f"{before.rstrip()}\n\n{begin}\n{body.strip()}\n{end}{after}")


def table(rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; the first row is its head."""
    lines = [list(rows[0]), ["---"] * len(rows[0]), *(list(row) for row in rows[1:])]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
