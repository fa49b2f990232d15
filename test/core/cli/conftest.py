"""One recorded session and its calibration: the second robot, three double supports."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from shoecal_core import cli

ROOT = Path(__file__).resolve().parents[3]
ROBOT = ROOT / "test" / "data" / "robots" / "odd_biped.yaml"
SHOE = ROOT / "test" / "data" / "shoes" / "odd_shoe.yaml"
WREN = ROOT / "config" / "robots" / "wren.yaml"
WREN_SHOE = ROOT / "config" / "shoes" / "wren_shoe.yaml"

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def shoecal(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the command line: exit code, standard output, standard error."""

    def run(*words: object) -> tuple[int, str, str]:
        code = cli.main([str(word) for word in words])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated session of the second robot: three cells left, six right, one inverted."""
    folder = tmp_path_factory.mktemp("simulated") / "session"
    figures = folder.with_name("figures.json")
    words = ["simulate", ROBOT, SHOE, "--supports", "4", "--seed", "6", "--rate", "50"]
    code = cli.main([str(word) for word in (*words, "--out", folder, "--json", figures)])
    assert code == 0
    assert len(json.loads(figures.read_text())["runs"]) == 4
    return folder


@pytest.fixture(scope="session")
def calibrated(simulated: Path) -> Path:
    """The calibration of that session; its figures stand beside it, `.json`."""
    path = simulated.with_name("calibration.yaml")
    words = ["calibrate", simulated, "--train", "1,2,3", "--test", "4", "--out", path]
    words += ["--json", path.with_suffix(".json")]
    assert cli.main([str(word) for word in words]) == 0
    return path
