"""The table of faults: a section of docs/evidence/reliability.md, and out/faults.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pages import Row, markdown, write_section
from reliability.row import Result
from reliability.rows import Found
from shoecal_core.files import atomic_write

SECTION = "faults"
HEAD = "# Faults and load\n"
SOURCES = "../../benchmarks/reliability"
"""From the page to the modules of the rows."""

BODY = """\
Made by `make faults`. *Worst*: result of the worst try; numbers in it are those of its step, counts
behind a semicolon those of all tries. Fault and details of each row are below the table.

{table}

{about}
"""

Shown = Mapping[str, tuple[Found, Result]]
"""Rows and their results, by key."""


def write_json(rows: Shown, file: Path) -> None:
    """Write every row, tried or not, as a list of objects."""
    plain = [
        {
            "fault": found.row.fault,
            "tried": result.tried,
            "failed": result.failed,
            "worst": result.text,
        }
        for found, result in rows.values()
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, json.dumps(plain, indent=1, ensure_ascii=False) + "\n")


def write_page(rows: Shown, page: Path) -> None:
    """Write the table of all rows and, below it, a section on each.

    Args:
        rows: by their keys.
        page: Markdown file; its other sections stay.
    """
    lines: list[Row] = []
    about = []
    for key, (found, result) in rows.items():
        tried, full = result.tried, found.row.tries
        share = f"{tried:,}" if tried >= full else f"{tried:,} of {full:,}"
        failed = f"**{result.failed:,}**" if result.failed else "0"
        lines.append(
            {
                "row": f"[`{key}`](#{key})",
                "must hold": found.row.holds,
                "tried": share,
                "failed": failed if tried else "",
                "worst": result.text,
            }
        )
        details = f"[details]({SOURCES}/{found.module}.py)"
        about.append(f"### `{key}`\n\nFault: {found.row.fault}.\n\n{found.about} ({details})")
    page.parent.mkdir(parents=True, exist_ok=True)
    write_section(SECTION, BODY.format(table=markdown(lines), about="\n\n".join(about)), page, HEAD)
