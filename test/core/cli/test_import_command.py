"""`shoecal import`: from a bag to a session, and what it says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import WREN_SHOE
from core.recording import bags
from shoecal_core.cli import main
from shoecal_core.robot.robot_file import load_robot

NOTE = "/joint_states: 1 of 201 messages have a stamp that repeats or goes back; they are left out"


def test_a_draft_with_the_shoe_of_another_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], simulated: Path
) -> None:
    run, robot, out = simulated / "run_001.mcap", simulated / "robot.yaml", tmp_path / "map.yaml"
    words = ["draft", run, "--robot", robot, "--shoe", WREN_SHOE, "--out", out]
    assert main(["import", *map(str, words)]) == 1
    told = capsys.readouterr().err
    assert "has no topic that fits 'wren_shoe'" in told
    assert "/shoe/voltages names " in told
    assert "; name the shoe that was recorded (--shoe)" in told
    assert not out.exists()


def test_draft_and_import_of_a_bag(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    robot, shoe = bags.robot_files(tmp_path)
    joints = load_robot(robot).joint_names
    bag = bags.walk(tmp_path, "walk", "ros1", joints)
    bag.add(1.0, "/joint_states", bag.joint_state(-1.0, list(joints), np.zeros(len(joints))))
    bag.close()
    draft = ["draft", "walk.bag", "--robot", str(robot), "--shoe", str(shoe), "--out", "map.yaml"]
    assert main(["import", *draft, "--json", "draft.json"]) == 0
    told = capsys.readouterr().out
    assert "  joints: /joint_states\n" in told
    assert "    rotation_rpy_rad turns frame 'left_sensor' of the URDF to axes parallel" in told
    assert told.endswith(f"Then: shoecal import bag map.yaml {tmp_path} --out SESSION\n")
    figures = json.loads(Path("draft.json").read_text())
    assert figures["fields"]["imu"] == {"topics": ["/imu/data"], "chosen": True, "notes": []}
    assert main(["import", *draft]) == 1
    assert "map.yaml: exists already" in capsys.readouterr().err

    words = ["bag", "map.yaml", ".", "--out", "session", "--json", "import.json"]
    assert main(["import", *words]) == 0
    told = capsys.readouterr().out
    assert told.splitlines() == [
        "session: 1 runs of robot 'wren'",
        f"  run 1: {NOTE}",
    ]
    assert json.loads(Path("import.json").read_text())["runs"][0]["notes"] == [NOTE]
    main(["check", "session"])
    assert "/joint_states: 1 of 201 messages" in capsys.readouterr().out
