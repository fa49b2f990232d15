"""Every command of README and docs: run, or checked where a test cannot run it.

A fenced block of `sh` is run, page by page, in one folder that looks like a fresh checkout,
unless the line before it says `<!-- not run: why -->`. What is said twice is run once.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from docs.command_check import problem
from docs.pages import ROOT, Block, blocks, make_calls

SHELLS = ("sh", "bash", "console")
TIMEOUT_S = 240.0
ALLOWED = ("shoecal", ".venv/bin/shoecal", ".venv/bin/python", "cp", "mkdir", "cat")
"""What a block that is run may start."""


def shell_blocks() -> list[Block]:
    return [block for block in blocks() if block.language in SHELLS]


def name_of(block: Block) -> str:
    return f"{block.page}:{block.line}"


@pytest.mark.parametrize("block", shell_blocks(), ids=name_of)
def test_commands_could_be_run(block: Block) -> None:
    for command in block.commands:
        for part in command.split(" && "):
            assert not problem(part), part


def test_calls_of_make_are_right() -> None:
    for page, call in make_calls():
        assert not problem(call), f"{page}: {call}"


def test_options_of_synopses_exist() -> None:
    for block in blocks():
        if block.language == "text":
            for line in block.text.splitlines():
                if line.startswith("shoecal "):
                    known = (ROOT / "docs/reference/commands.md").read_text()
                    options = {word.strip("[]") for word in line.split() if "--" in word}
                    lost = {option for option in options if f"`{option}`" not in known}
                    assert not lost, f"{name_of(block)}: {lost}"


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks like a checkout in which `make setup` has been called."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("config", ".venv"):
        (folder / name).symlink_to(ROOT / name)
    for block in blocks():
        if block.title:
            file = folder / block.title
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text)
    return folder


@pytest.mark.timeout(900)
def test_commands_run(checkout: Path) -> None:
    done: set[str] = set()
    # Where ROS is installed as packages there is no .venv: the command is on the PATH.
    environment = os.environ | {"PATH": f"{ROOT}/.venv/bin:{os.environ['PATH']}"}
    for block in shell_blocks():
        new = [command for command in block.commands if command not in done]
        if block.not_run or not new:
            continue
        for command in new:
            program = command.split()[0]
            assert program in ALLOWED, f"{name_of(block)}: why is '{program}' to be run?"
            result = subprocess.run(
                command, shell=True, cwd=checkout, env=environment, capture_output=True, text=True,
                timeout=TIMEOUT_S, check=False,
            )  # fmt: skip
            fails = bool(block.fails) and command == new[-1]
            assert (result.returncode != 0) == fails, (
                f"{name_of(block)}: {command}\n{result.stdout}{result.stderr}"
            )
            assert "Traceback" not in result.stderr, result.stderr
            done.add(command)
    assert len(done) > 10
