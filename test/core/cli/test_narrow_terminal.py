"""What commands print where there are 60 columns."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from core.cli.conftest import ROBOT, ROOT, SHOE, Run
from core.recording import bags
from shoecal_core.robot.robot_file import load_robot

WIDTH = 60
COMMAND = re.compile(r" *((Next|Then): )?shoecal ")
COMMANDS = {
    "check": "check SESSION",
    "calibrate": "calibrate SESSION --train 1,2,3 --test 4 --out OUT/calibration.yaml",
    "diagnose": "diagnose SESSION --no-simulation",
    "evaluate": "evaluate SESSION --calibration CALIBRATION",
    "history": "history CALIBRATION",
    "apply": "apply SESSION --calibration CALIBRATION --out OUT/applied",
    "plan": f"plan {ROBOT} --shoe {SHOE} --supports 1 --out OUT/plan",
    "simulate": f"simulate {ROBOT} {SHOE} --supports 1 --rate 20 --out OUT/session",
    "new": f"new robot {ROOT}/config/robots/wren.urdf -o OUT/wren.yaml",
}


def require_narrow(told: str) -> None:
    """No figure is cut, and no sentence is longer than the terminal is wide."""
    lines = told.splitlines()
    assert lines
    assert "…" not in told
    for line in lines:
        breakable = len(line.split()) > 1 and not COMMAND.match(line)
        assert len(line) <= WIDTH or not breakable, line
        assert not re.search(r"\d ±$", line.rstrip()), line
        assert not re.match(r" *[±%]( |$)", line), line


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command(
    name: str, simulated: Path, calibrated: Path, tmp_path: Path, shoecal: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    places = {"SESSION": simulated, "CALIBRATION": calibrated, "OUT": tmp_path}
    words = [
        re.sub("|".join(places), lambda match: str(places[match[0]]), word)
        for word in COMMANDS[name].split()
    ]
    code, told, error = shoecal(*words)
    assert code == 0, error
    require_narrow(told)


def test_the_import_of_a_bag(tmp_path: Path, shoecal: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    robot, shoe = bags.robot_files(tmp_path)
    bags.walk(tmp_path, "walk", "ros1", load_robot(robot).joint_names).close()
    mapping = tmp_path / "map.yaml"
    words = ["--robot", robot, "--shoe", shoe, "--out", mapping]
    code, told, error = shoecal("import", "draft", tmp_path / "walk.bag", *words)
    assert code == 0, error
    require_narrow(told)
    code, told, error = shoecal("import", "bag", mapping, tmp_path, "--out", tmp_path / "session")
    assert code == 0, error
    require_narrow(told)
