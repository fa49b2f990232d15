"""`shoecal history`: a robot's calibrations over time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import ROBOT, Run
from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.recording.imports.foreign import joint_states, voltages
from shoecal_core.recording.schemas import GOOD
from shoecal_core.recording.session import Session
from shoecal_core.shoe.wrench import ChannelParameters

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
    assert "1970" not in told + report.read_text()
    assert f"simulated, {first['made_ns'] / 1e9:.0f} s" in told
    page = report.read_text()
    assert page.count("<svg") >= 4
    # The first has not changed against itself, and is folded away; the latest says what to do.
    assert "0.00 %" in page
    assert page.count("0.00 %") == len(second["channels"])
    assert "1 earlier calibration" in page
    assert "/shoe/set_calibration" in page


def test_zeros_that_moved_between_two_sessions(
    tmp_path: Path, simulated: Path, calibrated: Path, shoecal: Run
) -> None:
    """The same motions a week later, every zero of the left foot moved by 10 N."""
    first = Session.open(simulated)
    second = Session.create(
        tmp_path / "second",
        *(simulated / name for name in ("robot.yaml", "robot.urdf", "shoe.yaml")),
    )
    before = load_calibration(calibrated)
    left = np.array([name.startswith("left/") for name in before.channels])
    for entry in first.runs[:3]:
        run = first.read(entry.run)
        start = run.start_ns + WEEK_NS
        moved = run.readings.value - np.where(left, 10.0 / before.parameters.gain, 0.0)
        moved[run.readings.status != GOOD] = np.nan
        sent = joint_states(stamps(start, run.joints.time), run.joints.names, run.joints.position)
        sent += voltages(stamps(start, run.readings.time), run.readings.names, moved)
        with second.new_run(entry.info.motion, entry.info.support) as writer:
            for one in sorted(sent, key=lambda one: one.stamp_ns):
                writer.write(one.topic, one.data, one.stamp_ns)
    after, figures = tmp_path / "after.yaml", tmp_path / "history.json"
    code, _, err = shoecal("calibrate", second.folder, "--out", after)
    assert code == 0, err
    code, _, err = shoecal("history", after, calibrated, "--json", figures)
    assert code == 0, err
    old, new = (one["zero_sum_n"] for one in json.loads(figures.read_text())["calibrations"])
    assert new["left"] - old["left"] == pytest.approx(10.0 * left.sum(), abs=3.0)
    assert new["right"] == pytest.approx(old["right"], abs=3.0)


def stamps(start: int, time: FloatArray) -> IntArray:
    return start + np.rint(1e9 * time).astype(np.int64)


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
