"""Figures as JSON, and pages made of them: docs/evidence and out/bench.json.

Each benchmark owns sections of a page, between `<!-- name -->` and `<!-- /name -->`, and one key of
a file of figures; it replaces its own and leaves the rest as it is.
"""

from __future__ import annotations

import fcntl
import json
import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path

import numpy as np

from shoecal_core.files import atomic_write

ROOT = Path(__file__).resolve().parents[1]
FIGURES = ROOT / "out" / "bench.json"
EVIDENCE = ROOT / "docs" / "evidence"
PERFORMANCE = EVIDENCE / "performance.md"
TRUST = EVIDENCE / "trust.md"

Row = Mapping[str, object]
"""One row of a table: its cells by the heads of their columns."""


def record(key: str, value: object, path: Path = FIGURES) -> None:
    """Write one benchmark's figures, keeping the others', also while another one writes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        known = json.loads(path.read_text()) if path.is_file() else {}
        known[key] = value
        atomic_write(path, json.dumps(known, indent=1, sort_keys=True, allow_nan=False) + "\n")


def write_section(name: str, body: str, page: Path, head: str = "") -> None:
    """Write a section in its place, or behind the others; a new page begins with `head`.

    Evidence says which version it is of: code goes on, and tables stay until they are renewed.
    """
    text = page.read_text() if page.is_file() else head
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, found, rest = text.partition(begin)
    after = rest.partition(end)[2] if found else "\n"
    stamp = f"\n\n{version()}" if page.resolve().is_relative_to(EVIDENCE) else ""
    atomic_write(page, f"{before.rstrip()}\n\n{begin}\n{body.strip()}{stamp}\n{end}{after}")


def version() -> str:
    """Version and commit of the code that measures, in a line."""
    known = f"Version {metadata.version('shoecal_core')}"
    asked = ("git", "log", "-1", "--format=%h of %cs")
    try:
        done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):  # a copy without its history
        return f"{known}."
    return f"{known}, commit {done.stdout.strip()}."


def markdown(rows: Sequence[Row]) -> str:
    """A Markdown table; its columns are the keys of the first row, in their order."""
    heads = list(rows[0])
    lines = [heads, ["---"] * len(heads), *([cell(row[head]) for head in heads] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def cell(value: object) -> str:
    """A figure as it stands in a table: three digits, or all of a whole number."""
    if value is None:
        return "-"
    if isinstance(value, float):
        # Never 1.2e+03.
        return f"{value:,.0f}" if 1e3 <= abs(value) < 1e15 else f"{value:.3g}"
    if isinstance(value, int):
        return f"{value:,}"
    return str(value).replace("|", r"\|").replace("\n", " ")


def machine() -> str:
    """What figures of speed were measured on."""
    return (
        f"Measured on {os.cpu_count()} cores ({platform.machine()}), OPENBLAS_NUM_THREADS "
        f"{os.environ.get('OPENBLAS_NUM_THREADS', 'not set')}, with Python "
        f"{platform.python_version()} and numpy {np.__version__}."
    )
