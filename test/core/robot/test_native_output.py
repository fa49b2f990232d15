"""What C++ prints is caught, and nothing else is changed."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.robot import robots
from shoecal_core.errors import FileError
from shoecal_core.robot.native_output import STDERR, caught_stderr
from shoecal_core.robot.urdf import read_urdf


def test_lines_are_caught_and_stderr_comes_back(capfd: pytest.CaptureFixture[str]) -> None:
    with caught_stderr() as lines:
        os.write(STDERR, b"Error:   one\n\xff two\n")
        assert not lines
    os.write(STDERR, b"after\n")
    assert lines == ["Error:   one", "\N{REPLACEMENT CHARACTER} two"]
    assert capfd.readouterr().err == "after\n"


def test_stderr_comes_back_after_an_error(capfd: pytest.CaptureFixture[str]) -> None:
    with contextlib.suppress(ValueError), caught_stderr() as lines:
        os.write(STDERR, b"caught\n")
        raise ValueError
    os.write(STDERR, b"after\n")
    assert lines == ["caught"]
    assert capfd.readouterr().err == "after\n"


def test_a_process_without_stderr() -> None:
    code = (
        "import os; from shoecal_core.robot.native_output import caught_stderr; os.close(2)\n"
        "with caught_stderr() as lines: print('done')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "done\n"


def test_a_bad_urdf_is_one_error_and_no_more(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    text = robots.FILES["wren"].with_suffix(".urdf").read_text()
    path = tmp_path / "light.urdf"
    path.write_text(text.replace('<mass value="1.3"/>', ""))
    with pytest.raises(FileError, match="link body; give it in kg"):
        read_urdf(path)
    path.write_text(text.replace("</robot>", "<link name='odd'/></robot>"))
    with pytest.raises(FileError, match="Two root links found"):
        read_urdf(path)
    assert not capfd.readouterr().err
