"""Signs of life of long commands."""

from __future__ import annotations

import time

import pytest

from shoecal_core.cli.parsers import COMMANDS
from shoecal_core.cli.program import STEPLESS
from shoecal_core.cli.progress import still_working


def test_a_long_command_says_that_it_goes_on(capsys: pytest.CaptureFixture[str]) -> None:
    with still_working("check", every=0.02):
        time.sleep(0.2)
    assert "shoecal check: still working (0 s)" in capsys.readouterr().err
    time.sleep(0.05)
    assert not capsys.readouterr().err


def test_the_commands_without_steps_are_commands() -> None:
    assert set(STEPLESS) <= set(COMMANDS)
