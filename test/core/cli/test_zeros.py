"""Zeros of each trial, the weight and verdicts, from the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from core.cli.conftest import Run
from core.cli.stepping import WEIGHT_KG, Stepping, stepping_session

ZEROS = ((-3.0, 2.0), (-2.8, 2.1), (-2.9, 1.9), (1.0, 5.5))
"""Of three runs of one day and one of another [N]."""
HEAVIER = 1.08


@pytest.fixture(scope="module")
def stepping(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("stepping") / "session"
    return stepping_session(folder, [Stepping(zeros) for zeros in ZEROS], HEAVIER).folder


def figures(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def check_zeros(found: list[dict[str, Any]], runs: tuple[int, ...]) -> None:
    assert [(one["run"], one["foot"]) for one in found] == [
        (run, foot) for run in runs for foot in ("left", "right")
    ]
    for one in found:
        true = ZEROS[one["run"] - 1][("left", "right").index(one["foot"])]
        assert one["fz_n"] == pytest.approx(true, abs=0.2)
        assert one["ci95"][0] - 0.2 < true < one["ci95"][1] + 0.2


def test_check_lists_zeros_and_weight(shoecal: Run, stepping: Path, tmp_path: Path) -> None:
    path = tmp_path / "check.json"
    code, out, error = shoecal(
        "check", stepping, "--json", path, "--report", tmp_path / "check.html"
    )
    found = figures(path)
    check_zeros(found["zeros"], (1, 2, 3, 4))
    assert found["weight"]["data_sheet_kg"] == pytest.approx(HEAVIER * WEIGHT_KG, rel=0.01)
    assert found["weight"]["robot_file_kg"] == pytest.approx(WEIGHT_KG)
    assert "by the data sheets of its sensors the robot weighs" in out
    assert "Feet in the air" in (tmp_path / "check.html").read_text()
    assert code == 0, out + error


def test_a_run_of_another_day_needs_its_own_zeros(
    shoecal: Run, stepping: Path, tmp_path: Path
) -> None:
    calibration, path = tmp_path / "calibration.yaml", tmp_path / "figures.json"
    code, out, error = shoecal(
        "calibrate", stepping, "--train", "1,2,3", "--out", calibration, "--json", path,
        "--weight-kg", str(HEAVIER * WEIGHT_KG),
    )  # fmt: skip
    assert code == 0, out + error
    found = figures(path)
    check_zeros(found["zeros"], (1, 2, 3))
    assert found["channels"]["left/fz"]["gain"] == pytest.approx(1.0, abs=0.02)
    words = ["evaluate", stepping, "--calibration", calibration, "--train", "1,2,3", "--test", "4"]
    words += ["--weight-kg", str(HEAVIER * WEIGHT_KG), "--json", path]
    code, out, error = shoecal(*words)
    assert code == 1
    found = figures(path)
    assert found["verdict"] == "FAIL"
    assert "feet in the air do not read zero (run 4: left +4 N, right +4 N" in " ".join(
        found["reasons"]
    )
    assert found["against_modelled"]["test"]["grf_mae_n"] > 5.0
    code, out, error = shoecal(*words, "--rezero")
    found = figures(path)
    assert found["verdict"] != "FAIL", found["reasons"]
    assert code == 0, out + error
    assert found["against_modelled"]["test"]["grf_mae_n"] < 0.5


def test_a_failed_calibration_leaves_its_figures(
    shoecal: Run, stepping: Path, tmp_path: Path
) -> None:
    path = tmp_path / "figures.json"
    code, _, _ = shoecal(
        "calibrate", stepping, "--train", "1,2,3", "--test", "4", "--json", path,
        "--out", tmp_path / "none.yaml",
    )  # fmt: skip
    assert code == 1
    found = figures(path)
    assert (found["verdict"], "error" in found) == ("FAIL", True)
    # The weight is the first finding that is no failure.
    assert "by the data sheets of its sensors" in next(
        one for one in found["reasons"] if one.startswith("WARN")
    )
    assert {"zeros", "channels", "against_model"} <= set(found)


def test_feet_that_carry_a_tenth_are_never_in_the_air(shoecal: Run, tmp_path: Path) -> None:
    runs = [Stepping((-3.0, 2.0), least=0.1), Stepping((0.0, 0.0), least=0.2)]
    folder = stepping_session(tmp_path / "session", runs).folder
    path = tmp_path / "check.json"
    shoecal("check", folder, "--json", path)
    assert figures(path)["zeros"] == []
