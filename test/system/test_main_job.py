"""The whole main job over ROS 2: processes, DDS, serial bytes, MCAP files, the second robot."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import read_yaml
from shoecal_core.planning.motion_sets import MOTION_SETS, STANDARD
from shoecal_core.recording.session import Session
from shoecal_core.workflows.calibrate import calibrate_session

ROOT = Path(__file__).resolve().parents[2]
ROBOT = ROOT / "test" / "data" / "robots" / "odd_biped.yaml"
SHOE = ROOT / "test" / "data" / "shoes" / "odd_shoe.yaml"
SHOECAL = Path(sys.executable).with_name("shoecal")

PAPER_GRF_N, PAPER_COP_MM = 0.35, 2.8
"""Errors on test runs of the paper's robot; no run may be worse than one and a half times that."""


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished demo: the standard set in three supports and the neutral one."""
    out = tmp_path_factory.mktemp("demo") / "out"
    words = ["demo", "--robot", ROBOT, "--shoe", SHOE, "--supports", "3", "--train", "2"]
    done = subprocess.run(
        [str(word) for word in (SHOECAL, *words, "--seed", "3", "--out", out)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def result(demo: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((demo / "result.json").read_text())
    return found


def test_the_result_holds_what_it_promises(result: dict[str, Any]) -> None:
    assert result["format"] == 1
    assert result["robot"] == "odd_biped"
    assert result["seed"] == 3
    assert [row["set"] for row in result["supports"]] == 4 * ["train"] + 3 * ["test"]
    assert {"run", "dx", "dy", "dtheta", "set"} <= result["supports"][0].keys()
    assert {"grf_mae_n", "cop_mae_mm"} <= result["modelled"].keys()
    wanted = {
        "grf_mae_n", "cop_mae_mm", "left_cop_mae_mm", "right_cop_mae_mm",
        "left_grf_mae_n", "right_grf_mae_n",
    }  # fmt: skip
    assert wanted <= result["self_calibration"]["test"].keys()
    assert {"plan", "record", "solve", "total"} <= result["timing_s"].keys()


def test_held_out_errors_are_the_papers(result: dict[str, Any]) -> None:
    test = result["self_calibration"]["test"]
    heavier = 8.66 / 5.48
    assert test["grf_mae_n"] < 1.5 * heavier * PAPER_GRF_N
    assert test["cop_mae_mm"] < 1.5 * PAPER_COP_MM
    guess = result["initial_guess"]["test"]
    assert test["grf_mae_n"] < guess["grf_mae_n"]
    assert test["cop_mae_mm"] < guess["cop_mae_mm"]


def test_gains_come_near_the_drawn_ones(demo: Path) -> None:
    found = load_calibration(demo / "calibration.yaml")
    drawn = next((demo / "session" / "truth").glob("*.yaml"))
    gains = read_yaml(drawn).mapping("gain")
    true = np.array([gains.number(name) for name in found.channels])
    np.testing.assert_allclose(found.parameters.gain, true, rtol=0.2)
    assert np.sum(true < 0.0) == 1  # the inverted cell


def test_the_recording_opens_in_rosbags(demo: Path) -> None:
    runs = sorted((demo / "session").glob("run_*.mcap"))
    assert len(runs) == 7
    with AnyReader(runs[:1]) as reader:
        topics = {connection.topic for connection in reader.connections}
        assert {"/joint_states", "/joint_trajectory", "/shoe/voltages"} <= topics
        voltages = [one for one in reader.connections if one.topic == "/shoe/voltages"]
        sequence = [
            reader.deserialize(data, connection.msgtype).sequence  # type: ignore[attr-defined]
            for connection, _, data in reader.messages(voltages)
        ]
    # Not one frame is lost between the device and the file.
    np.testing.assert_array_equal(np.diff(np.array(sequence, dtype=np.int64)), 1)


def test_the_recording_is_solved_again_to_the_same_parameters(demo: Path) -> None:
    applied = load_calibration(demo / "calibration.yaml")
    again = calibrate_session(Session.open(demo / "session")).calibration
    np.testing.assert_allclose(again.parameters.gain, applied.parameters.gain, rtol=1e-9)
    np.testing.assert_allclose(again.parameters.offset, applied.parameters.offset, atol=1e-9)


def test_no_process_is_left_behind(demo: Path) -> None:
    left = [
        line
        for line in subprocess.run(
            ["ps", "-eo", "args"], capture_output=True, text=True, check=True
        ).stdout.splitlines()
        if str(demo) in line and str(os.getpid()) not in line
    ]
    assert not left


def test_runs_train_until_the_target_is_reached(tmp_path: Path) -> None:
    """A target that few runs reach: those that test are recorded all the same."""
    out = tmp_path / "out"
    words = ["demo", "--robot", ROBOT, "--shoe", SHOE, "--supports", "3", "--train", "2"]
    words += ["--seed", "3", "--target", "40", "--out", out]
    done = subprocess.run(
        [str(word) for word in (SHOECAL, *words)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    hints = [run.hint for run in Session.open(out / "session").runs]
    standard = MOTION_SETS[STANDARD]
    assert 2 <= hints.count("train") < len(standard.train)
    assert hints.count("test") == len(standard.test)
    log = (out / "logs" / "calibrator.log").read_text()
    assert re.search(r"target 40 mm reached: expected CoP error of a foot [\d.]+ mm", log)
    assert json.loads((out / "result.json").read_text())["verdict"] != "FAIL"


def test_an_unwritable_folder_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = subprocess.run(
        [str(SHOECAL), "demo", "--out", str(tmp_path / "file" / "out")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
