"""Prose of README and docs uses the field's words: what is generated or quoted does not count."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from docs.pages import ROOT, pages

AVOIDED = {
    "told": "reported, detected",
    "tells": "reports, shows",
    "foretold": "predicted",
    "beside": "next to, in addition to",
    "nobody": "passive voice",
    "whoever": "name the program or person",
    "surmise": "hypothesis",
    "mend": "repair, correct",
    "anew": "again",
}
"""Words that slow a reader down, and what to write instead."""
GENERATED = re.compile(r"reference/(commands|files|index|interfaces|launch|parameters|topics)\.md$")
_QUOTED = re.compile(r"`[^`]*`|\*[^*]+\*")


def prose(page: Path) -> Iterator[tuple[int, str]]:
    """Lines of text, without fences, tables, code and italics."""
    inside = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if line.lstrip().startswith("```"):
            inside = not inside
        elif not inside and not line.startswith("|"):
            yield number, _QUOTED.sub("", line)


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_prose_uses_plain_words(page: Path) -> None:
    if GENERATED.search(str(page)) or page.parent.name == "evidence":
        pytest.skip("written by programs")
    found = [
        f"line {number}: '{word}': {better}"
        for number, line in prose(page)
        for word, better in AVOIDED.items()
        if re.search(rf"\b{word}\b", line, re.IGNORECASE)
    ]
    assert not found, "\n".join(found)


PUBLIC_NAMES = re.compile(r"temperatures?_told|NOBODY_LISTENS|nobody-listens")
"""Keys of files and codes of diagnostics that were given before."""
CODE = sorted(
    file
    for package in ("shoecal_core/shoecal_core", "shoecal_ros/shoecal_ros", "shoecal_ros/launch")
    for file in (ROOT / package).rglob("*.py")
)


def test_code_uses_plain_words() -> None:
    """In names, comments, docstrings and messages alike."""
    assert CODE
    words = re.compile(rf"(?<![a-z])({'|'.join(AVOIDED)})(?![a-z])", re.IGNORECASE)
    found = [
        f"{file.relative_to(ROOT)}:{number}: '{match[0]}': {AVOIDED[match[0].lower()]}"
        for file in CODE
        for number, line in enumerate(file.read_text().splitlines(), 1)
        for match in words.finditer(PUBLIC_NAMES.sub("", line))
    ]
    assert not found, "\n".join(found)
