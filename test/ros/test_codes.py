"""Codes are distinct, and the page on them says the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from shoecal_core.errors import ShoecalError, error_code
from shoecal_ros.common.codes import Code
from shoecal_ros.inputs import joining, joints

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/reference/diagnostics.md").read_text()
DEFINITIONS = [
    *sorted((ROOT / "shoecal_msgs/action").glob("*.action")),
    *sorted((ROOT / "shoecal_msgs/srv").glob("*.srv")),
]
SOURCES = {
    file: file.read_text()
    for package in ("shoecal_core", "shoecal_ros")
    for file in sorted((ROOT / package / package).rglob("*.py"))
}
CODES = ROOT / "shoecal_ros/shoecal_ros/common/codes.py"
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
    assert row is not None, f"{file.stem} is missing in docs/reference/diagnostics.md"
    assert row[1] == ", ".join(f"{number} `{name}`" for name, number in refusals)


def test_answers_of_starting_are_those_of_the_action() -> None:
    text = (ROOT / "shoecal_msgs/srv/SelfCalibrate.srv").read_text()
    assert "uint16 error_code # constants of Calibrate's result" in text


def error_codes() -> set[str]:
    """Of all errors there are."""
    names = {
        name
        for text in SOURCES.values()
        for name in re.findall(r"^class (\w+Error)\(", text, re.MULTILINE)
    }
    return {error_code(type(name, (ShoecalError,), {})) for name in names}


def documented() -> set[str]:
    """Codes in the table of diagnostics."""
    column = re.findall(r"^\|[^|]*\| (?:WARN|ERROR) \| ([^|]*) \|", PAGE, re.MULTILINE)
    assert all("`" in cell or "the [error's]" in cell for cell in column)
    return {code for cell in column for code in re.findall(r"`([a-z-]+)`", cell)}


def test_codes_of_diagnostics_are_those_on_the_page() -> None:
    reported = set(Code) - {Code.OK, Code.ENDED}
    assert documented() - error_codes() == reported
    passed_on = {
        error_code(kind)
        for module in (joining, joints)
        for kind in vars(module).values()
        if isinstance(kind, type) and kind.__module__ == module.__name__
        if issubclass(kind, ShoecalError)
    }
    assert passed_on <= documented()
    for code in (Code.OK, Code.ENDED):
        assert f"`{code}`" in PAGE


def test_a_code_of_diagnostics_is_no_error_s() -> None:
    assert not set(Code) & error_codes()


@pytest.mark.parametrize("code", Code)
def test_every_code_of_diagnostics_is_told_somewhere(code: Code) -> None:
    used = [file for file, text in SOURCES.items() if re.search(rf"\bCode\.{code.name}\b", text)]
    assert set(used) - {CODES}
    assert code.name.lower().replace("_", "-") == code
