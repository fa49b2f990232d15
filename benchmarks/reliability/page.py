"""The table of faults: a section of docs/evidence/reliability.md, and out/faults.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pages import table, write_section
from reliability.shown import Shown, brief, counted, link, summary
from shoecal_core.files import atomic_write

SECTION = "faults"
HEAD = "# Faults and load\n"
SOURCES = "../../benchmarks/reliability"
"""From the page to the rows' modules, whose docstrings say what is done and what is simulated."""

BODY = """\
Made by `make faults`. In short:

{summary}

*This code*: tries with the present sources, as far as the row can reach them (imports, nodes,
configuration, messages, data). *Worst*: result of the worst try; counts such as 4 of 500 are
those of one step. What each row does and what of it is simulated is in its module (*details*
below).

{table}

{about}
"""


def write_json(rows: Mapping[str, Shown], file: Path) -> None:
    """Every row, tried or not, as a list of objects."""
    told = [
        {
            "fault": one.found.row.fault,
            "tried": one.result.tried,
            "failed": one.result.failed,
            "worst": "; ".join(filter(None, (one.result.told, one.failed_before))),
        }
        for one in rows.values()
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    atomic_write(file, json.dumps(told, indent=1, ensure_ascii=False) + "\n")


def write_page(rows: Mapping[str, Shown], page: Path) -> None:
    """All rows in short, their table, and what each does.

    Args:
        rows: by their keys.
        page: Markdown.
    """
    lines = [("row", "must hold", "tried", "this code", "failed", "worst")]
    for key, one in rows.items():
        lines.append(
            (
                link(key), one.found.row.holds, one.share, _present(one), _failed(one),
                brief(one.result.told),
            )
        )  # fmt: skip
    cells = [[cell.replace("|", r"\|").replace("\n", " ") for cell in line] for line in lines]
    about = "\n\n".join(_section(key, one) for key, one in rows.items())
    body = BODY.format(summary=summary(rows), table=table(cells), about=about)
    write_section(SECTION, body, page, HEAD)


def _present(one: Shown) -> str:
    if not one.result.tried:
        return ""
    return {one.result.tried: "all", 0: "none"}.get(one.present, f"{one.present:,}")


def _failed(one: Shown) -> str:
    failed = f"**{one.result.failed:,}**" if one.result.failed else "0"
    told = failed if one.result.tried else ""
    return "; ".join(filter(None, (told, brief(one.failed_before))))


def _section(key: str, one: Shown) -> str:
    """Fault, where it is explained in full, and what is too long for the table."""
    told = {
        "Worst": one.result.told,
        "Failed before, with the same code": counted(one.before),
    }
    long = [f"{head}: {text}" for head, text in told.items() if brief(text) != text]
    summary_line = one.found.about.partition("\n\n")[0]
    details = f"[details]({SOURCES}/{one.found.module}.py)"
    return "\n\n".join(
        (f"### `{key}`", f"Fault: {one.found.row.fault}.", f"{summary_line} ({details})", *long)
    )
