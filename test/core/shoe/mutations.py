"""Good files made bad: one value at a time by table, or anywhere by chance."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from hypothesis import strategies as st

from shoecal_core.errors import FileError
from shoecal_core.files import write_yaml

Key = str | int
DELETE = object()
"""As a new value: take the key away."""

NASTY = (
    "", " ", "\n", "\t", "0", "-1", "1e999", ".nan", ".inf", "nan", "inf", "true", "null", "~",
    "[]", "{}", "[", "}", ":", "- ", "#", "'", '"', "&a", "*a", "!!int ", "!x ", "%", "?", "\x00",
    "\u2028", "é", "9" * 320, "010", "1:30", "<", ">", "/>", "<link/>", "&amp;", "<!--", "1 2 3",
)  # fmt: skip
"""What typing errors, editors and attackers leave behind."""


def write_edited(target: Path, source: Path, *edits: tuple[tuple[Key, ...], object]) -> Path:
    """Write a YAML file with values at some places replaced, added or taken away."""
    whole = yaml.safe_load(source.read_text())
    for place, value in edits:
        inner = whole
        for key in place[:-1]:
            inner = inner[key]
        if value is DELETE:
            del inner[place[-1]]
        elif callable(value):
            inner[place[-1]] = value(copy.deepcopy(inner[place[-1]]))
        else:
            inner[place[-1]] = value
    write_yaml(target, whole)
    return target


@st.composite
def mutated(draw: st.DrawFn, text: str) -> str:
    """A text with one to four random edits: spans dropped, doubled, swapped or overwritten."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, max(0, len(text) - 1)))
        end = min(len(text), start + draw(st.sampled_from([0, 1, 1, 2, 5, 20, 200])))
        piece = text[start:end]
        kind = draw(st.integers(0, 3))
        if kind == 0:
            new = ""
        elif kind == 1:
            new = piece + piece
        elif kind == 2:
            new = piece[::-1]
        else:
            new = draw(st.sampled_from(NASTY))
        text = text[:start] + new + text[end:]
    return text


def refused(path: Path, call: Callable[[], object]) -> FileError:
    """The one error with which a call refuses a file; its message is a single short line."""
    with pytest.raises(FileError) as caught:
        call()
    assert caught.value.path == path
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert len(message) < len(str(path)) + 1500
    return caught.value
