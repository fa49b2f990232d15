"""Messages that docs/how-to/troubleshooting.md quotes are those that programs say."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

from docs.pages import ROOT

PAGE = ROOT / "docs/how-to/troubleshooting.md"
_QUOTED = re.compile(r"(?<!\*)\*([^*]+)\*(?!\*)")
_LEAST = 8
"""Letters of a piece between two `…` that is looked for."""


def squeezed(text: str) -> str:
    return " ".join(text.split())


@cache
def said() -> str:
    """Every text of the programs; what is put into one is left out."""
    found = [(ROOT / file).read_text() for file in ("scripts/setup.sh", "firmware/Makefile")]
    for package in ("shoecal_core", "shoecal_ros"):
        for file in sorted((ROOT / package / package).rglob("*.py")):
            found += _texts(file)
    return squeezed("\n".join(found))


def _texts(file: Path) -> list[str]:
    texts = []
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.JoinedStr):
            parts = (p.value for p in node.values if isinstance(p, ast.Constant))
            texts.append("…".join(map(str, parts)))
            texts.append("".join(_shown(part) for part in node.values))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return texts


def _shown(part: ast.expr) -> str:
    return str(part.value) if isinstance(part, ast.Constant) else "…"


def test_quoted_messages_exist() -> None:
    lost = []
    for line in PAGE.read_text().splitlines():
        first = line.strip("| ").split(" | ")[0] if line.startswith("|") else ""
        for quoted in _QUOTED.findall(first):
            pieces = [piece.strip(" ,") for piece in quoted.split("…")]
            lost += [
                f"{piece!r} of {quoted!r}"
                for piece in pieces
                if len(piece) >= _LEAST and squeezed(piece) not in said()
            ]
    assert not lost, "\n".join(lost)


def test_messages_are_quoted_at_all() -> None:
    rows = [line for line in PAGE.read_text().splitlines() if line.startswith("| *")]
    assert len(rows) > 30
