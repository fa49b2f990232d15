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
Made by `make faults`; *tried* beside *full size* says how much of it has been run.

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
            "worst": results[key].worst,
        }
        for key, found in rows.items()
        if results[key].tried
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, json.dumps(told, indent=1, ensure_ascii=False) + "\n")


def write_page(rows: Mapping[str, Found], results: Mapping[str, Result], page: Path) -> None:
    """The table, and what each row does."""
    lines = [("row", "fault", "must hold", "full size", "tried", "failed", "worst")]
    for key, found in rows.items():
        row, result = found.row, results[key]
        lines.append(
            (
                f"`{key}`", row.fault, row.holds, f"{row.tries:,}", f"{result.tried:,}",
                _failed(result), result.worst,
            )
        )  # fmt: skip
    cells = [[cell.replace("|", r"\|").replace("\n", " ") for cell in line] for line in lines]
    about = "\n\n".join(f"### `{key}`\n\n{found.about}" for key, found in rows.items())
    write_section(SECTION, BODY.format(table=table(cells), about=about), page, HEAD)


def _failed(result: Result) -> str:
    if not result.tried:
        return ""
    return f"**{result.failed:,}**" if result.failed else "0"
