"""Sections of pages: replaced in their place, and with the version that they are of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import pages


@pytest.fixture
def evidence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is taken for that of the evidence."""
    monkeypatch.setattr(pages, "EVIDENCE", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("# Page\n\n<!-- a -->\nold\n<!-- /a -->\n\nText.\n")
    return page


def test_a_section_is_replaced_and_says_its_version(evidence: Path) -> None:
    pages.write_section("a", "| new |", evidence)
    pages.write_section("b", "| more |", evidence)
    text = evidence.read_text()
    found = re.findall(
        r"<!-- (\w) -->\n(.*)\n\nVersion (\S+?)(?:, commit \w+ of [\d-]+)?\.\n", text
    )
    assert [(name, body) for name, body, _ in found] == [("a", "| new |"), ("b", "| more |")]
    assert "old" not in text
    assert text.index("Text.") < text.index("<!-- b -->")


def test_other_pages_hold_no_version(tmp_path: Path) -> None:
    page = tmp_path / "reference.md"
    pages.write_section("a", "| new |", page, head="# Reference\n")
    assert page.read_text() == "# Reference\n\n<!-- a -->\n| new |\n<!-- /a -->\n"
