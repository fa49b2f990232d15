"""Runs as session.yaml lists them."""

from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import FileError
from shoecal_core.files import read_yaml
from shoecal_core.recording.listing import read_support
from shoecal_core.robot.double_support import DoubleSupport


@pytest.mark.parametrize("text", ["[0.0, 1.0e+30, 0.0]", "[0.0, .nan, 0.0]", "[0.0, -0.1]", "5"])
def test_a_support_of_a_file_that_is_none_names_the_file_and_the_field(
    tmp_path: Path, text: str
) -> None:
    path = tmp_path / "list.yaml"
    path.write_text(f"support: {text}\n")
    with pytest.raises(FileError, match=r"list\.yaml.*support"):
        read_support(read_yaml(path))


def test_a_support_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "list.yaml"
    path.write_text("another: 1")
    assert read_support(read_yaml(path)) is None
    path.write_text("support: [0.01, -0.1, 0.2]\n")
    assert read_support(read_yaml(path)) == DoubleSupport(0.01, -0.1, 0.2)
