from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from shoecal_core.errors import FileError
from shoecal_core.parameter_file import load_settings
from shoecal_core.settings import SettingError, Settings, describe, from_values, setting


@dataclass(frozen=True)
class Example(Settings):
    length: float = setting(0.5, "m", "how long", minimum=0.0, maximum=2.0)
    count: int = setting(3, "", "how many", minimum=1)
    kind: str = setting("slow", "", "which", choices=("slow", "fast"))
    loud: bool = setting(False, "", "whether")


def write(path: Path, text: str) -> Path:
    file = path / "node.yaml"
    file.write_text(text)
    return file


def test_describes_every_field() -> None:
    entries = {entry.name: entry for entry in describe(Example)}
    assert list(entries) == ["length", "count", "kind", "loud"]
    assert entries["length"].kind is float
    assert entries["length"].unit == "m"
    assert entries["length"].default == 0.5
    assert entries["length"].maximum == 2.0
    assert entries["kind"].choices == ("slow", "fast")


def test_whole_numbers_serve_as_numbers() -> None:
    example = from_values(Example, {"length": 1})
    assert example.length == 1.0
    assert isinstance(example.length, float)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"lenght": 1.0}, ["lenght", "unknown", "length"]),
        ({"length": 3.0}, ["length", "at most 2", " m", "3 m"]),
        ({"length": "long"}, ["length", "a number"]),
        ({"length": float("nan")}, ["length", "finite"]),
        ({"length": 10**400}, ["length", "too large"]),
        ({"length": True}, ["length", "a number"]),
        ({"count": 0}, ["count", "at least 1"]),
        ({"count": 1.5}, ["count", "whole"]),
        ({"count": True}, ["count", "whole"]),
        ({"kind": "medium"}, ["kind", "slow, fast"]),
        ({"loud": 1}, ["loud", "true or false"]),
    ],
)
def test_bad_values_name_key_and_cure(values: dict[str, object], words: list[str]) -> None:
    with pytest.raises(SettingError) as caught:
        from_values(Example, values)
    for word in words:
        assert word in str(caught.value)


def test_holding_settings_means_they_are_valid() -> None:
    with pytest.raises(SettingError, match="length"):
        Example(length=-1.0)


def test_reads_a_ros_parameter_file(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "node: {ros__parameters: {robot: nao.yaml, part: {length: 1.25, kind: fast}}}\n"
        "other: {ros__parameters: {part: {length: 0.1}}}\n",
    )
    example = load_settings(Example, path, "node", "part")
    assert example == Example(length=1.25, kind="fast")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "node: {ros__parameters: {part: {length: 9.0}}}",
            ["part.length", "at most 2 m"],
        ),
        ("node: {ros__parameters: {part: {robot: nao.yaml}}}", ["part.robot", "unknown"]),
        ("node: {length: 1.0}", ["node.length", "expected a mapping"]),
        ("planner: {ros__parameters: {}}", ["/**/node", "missing", "only of planner"]),
        ("node: {ros__parameters: {part: {length: }}}", ["length", "missing"]),
    ],
)
def test_bad_files_name_file_and_key(tmp_path: Path, text: str, words: list[str]) -> None:
    path = write(tmp_path, text)
    with pytest.raises(FileError) as caught:
        load_settings(Example, path, "node", "part")
    for word in ["node.yaml", *words]:
        assert word in str(caught.value)
