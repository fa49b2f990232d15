"""Codes of refusals are distinct, and the page on them says the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/diagnostics.md").read_text()
DEFINITIONS = [
    *sorted((ROOT / "shoecal_msgs/action").glob("*.action")),
    *sorted((ROOT / "shoecal_msgs/srv").glob("*.srv")),
]
OWN = {"GetCalibration": "answers always", "SelfCalibrate": "those of Calibrate"}


def codes(file: Path) -> list[tuple[str, int]]:
    """Names and numbers of a definition's answer."""
    answer = file.read_text().split("---\n")[1]
    found = re.findall(r"^uint16 ([A-Z_]+)=(\d+)", answer, re.MULTILINE)
    return [(name, int(number)) for name, number in found]


@pytest.mark.parametrize("file", DEFINITIONS, ids=lambda file: file.stem)
def test_codes_are_distinct_and_documented(file: Path) -> None:
    if file.stem in OWN:
        assert not codes(file)
        return
    assert "uint16 error_code" in file.read_text()
    assert ("OK", 0) in codes(file)
    refusals = [(name, number) for name, number in codes(file) if number]
    assert len({number for _, number in refusals}) == len({name for name, _ in refusals})
    assert len(refusals) == len({number for _, number in refusals})
    row = re.search(rf"^\| \w+ `{file.stem}` \| (.*) \|$", PAGE, re.MULTILINE)
    assert row is not None, f"{file.stem} is missing in docs/diagnostics.md"
    assert row[1] == ", ".join(f"{number} `{name}`" for name, number in refusals)


def test_answers_of_starting_are_those_of_the_action() -> None:
    text = (ROOT / "shoecal_msgs/srv/SelfCalibrate.srv").read_text()
    assert "uint16 error_code # constants of Calibrate's result" in text
