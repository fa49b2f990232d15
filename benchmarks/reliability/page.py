"""The table of faults: a section of docs/reliability.md, and out/faults.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pages import table, write_section
from reliability.row import Result
from reliability.rows import Found
from shoecal_core.files import atomic_write

SECTION = "faults"
HEAD = "# Under load and faults\n"

BODY = """\
Made by `make faults`; *tried* beside *full size* says how much of it has been run, *this code* how
many of these tries ran with the very sources that stand beside this page (what the row can reach:
its imports, the nodes it starts and theirs, configuration, messages and data); the others ran with
earlier ones.
*worst* is what came of the worst try; where it counts some out of a round number (4 of 500), they
are those of one step of the row.

{table}

{about}
"""


def write_json(rows: Mapping[str, Found], results: Mapping[str, Result], file: Path) -> None:
    """Every row that was tried, as a list of objects."""
    told = [
        {
            "fault": found.row.fault,
            "tried": results[key].tried,
            "failed": results[key].failed,
            "worst": results[key].told,
        }
        for key, found in rows.items()
        if results[key].tried
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, json.dumps(told, indent=1, ensure_ascii=False) + "\n")


def write_page(
    rows: Mapping[str, Found], results: Mapping[str, Result], present: Mapping[str, int], page: Path
) -> None:
    """The table, and what each row does.

    Args:
        rows: by their keys.
        results: of each.
        present: how many of its tries ran with the code at hand.
        page: Markdown.
    """
    lines = [("row", "fault", "must hold", "full size", "tried", "this code", "failed", "worst")]
    for key, found in rows.items():
        row, result = found.row, results[key]
        lines.append(
            (
                f"`{key}`", row.fault, row.holds, f"{row.tries:,}", f"{result.tried:,}",
                f"{present[key]:,}" if result.tried else "", _failed(result), result.told,
            )
        )  # fmt: skip
    cells = [[cell.replace("|", r"\|").replace("\n", " ") for cell in line] for line in lines]
    about = "\n\n".join(f"### `{key}`\n\n{found.about}" for key, found in rows.items())
    write_section(SECTION, BODY.format(table=table(cells), about=about), page, HEAD)


def _failed(result: Result) -> str:
    if not result.tried:
        return ""
    return f"**{result.failed:,}**" if result.failed else "0"
