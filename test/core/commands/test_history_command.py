"""`shoecal history`: a robot's calibrations over time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.commands.conftest import ROBOT, Run
from shoecal_core.calibration.calibration import load_calibration, save_calibration
from shoecal_core.sensing.wrench import ChannelParameters

WEEK_NS = 7 * 86_400 * 10**9
SHIFT_N = 40.0


@pytest.fixture
def later(tmp_path: Path, calibrated: Path) -> Path:
    """A calibration a week later, the first channel's offset moved."""
    first = load_calibration(calibrated)
    offset = first.parameters.offset.copy()
    offset[0] += SHIFT_N
    moved = ChannelParameters(first.parameters.gain, offset)
    path = tmp_path / "later.yaml"
    made = first.made_ns + WEEK_NS
    save_calibration(replace(first, id="later", made_ns=made, parameters=moved), path)
    return path


def test_what_changed(calibrated: Path, later: Path, shoecal: Run) -> None:
    figures, report = later.with_suffix(".json"), later.with_suffix(".html")
    code, told, err = shoecal("history", later, calibrated, "--json", figures, "--report", report)
    assert code == 0, err
    first, second = json.loads(figures.read_text())["calibrations"]
    assert (Path(first["file"]), Path(second["file"])) == (calibrated, later)
    changes = np.array([one["offset_change"] for one in second["channels"]])
    np.testing.assert_allclose(changes, [SHIFT_N, *np.zeros(len(changes) - 1)], atol=1e-9)
    assert [one["offset_beyond_2_std"] for one in second["channels"]].count(True) == 1
    assert not any(one["gain_beyond_2_std"] for one in second["channels"])
    assert second["channels"][0]["name"] in told
    assert report.read_text().count("<svg") >= 4


def test_two_robots_are_refused(calibrated: Path, later: Path, shoecal: Run) -> None:
    save_calibration(replace(load_calibration(later), robot="other"), later)
    code, _, err = shoecal("history", calibrated, later)
    assert code == 1
    assert f"{later}: robot: is 'other', but" in err


def test_one_calibration_twice_is_refused(calibrated: Path, shoecal: Run) -> None:
    code, _, err = shoecal("history", calibrated, calibrated)
    assert code == 1
    assert "name each calibration once" in err


def test_a_robot_file_is_refused(calibrated: Path, shoecal: Run) -> None:
    code, _, err = shoecal("history", calibrated, ROBOT)
    assert code == 1
    assert str(ROBOT) in err
