"""Recorded readings as GRF and CoP: what the tables hold is what the calibration measures."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import Run
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workflows.apply import apply, at_own_zeros


def test_tables_hold_what_was_measured(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    code, out, _ = shoecal("apply", simulated, "--calibration", calibrated, "--out", tmp_path)
    assert code == 0
    session = Session.open(simulated)
    robot = load_robot(session.robot_yaml, session.shoe)
    sensing = load_calibration(calibrated).sensing(session.shoe)
    for entry in session.runs:
        file = tmp_path / f"run_{entry.run:03d}.csv"
        assert str(file) in out
        with file.open() as table:
            rows = list(csv.DictReader(table))
        run = session.read(entry.run)
        found = apply(run, sensing, Kinematics(robot))
        assert len(rows) == len(run.readings.time)
        for name, values in found.columns().items():
            told = np.array([float(row[name] or "nan") for row in rows])
            np.testing.assert_allclose(told, values, rtol=1e-6, atol=1e-9)
        # In one double support it is what both feet's wrenches give there.
        at = found.measured.combined_cop(entry.info.support)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.cop, at, atol=2e-3)
        truth = read_truth(session.truth_path(entry.run))
        assert np.nanmean(found.measured.total_grf) == pytest.approx(
            truth.foot_grf.sum(axis=1).mean(), rel=0.02
        )


def test_what_is_not_known_is_left_empty(simulated: Path, calibrated: Path) -> None:
    session = Session.open(simulated)
    robot = load_robot(session.robot_yaml, session.shoe)
    sensing = load_calibration(calibrated).sensing(session.shoe)
    run = session.read(1)
    run.readings.status[10, 0] = 2
    run.joints.position[:20] = np.nan
    found = apply(run, sensing, Kinematics(robot))
    assert np.isnan(found.measured.grf[10, 0])
    assert np.isfinite(found.measured.grf[10, 1])
    assert np.isnan(found.cop[:10]).all()
    assert np.isfinite(found.cop[-1]).all()
    # No foot hangs in any run: zeros stay as they were calibrated.
    same = at_own_zeros(session.read(1), sensing, Kinematics(robot))
    np.testing.assert_array_equal(same.parameters.offset, sensing.parameters.offset)


def test_a_calibration_of_other_shoes_is_doubted(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    code, out, _ = shoecal("apply", simulated, "--calibration", calibrated, "--out", tmp_path)
    assert code == 0
    assert "WARN" not in out
    calibration = load_calibration(calibrated)
    law = calibration.parameters
    other = tmp_path / "other.yaml"
    save_calibration(
        replace(calibration, parameters=ChannelParameters(1.1 * law.gain, 1.1 * law.offset)), other
    )
    code, out, _ = shoecal("apply", simulated, "--calibration", other, "--out", tmp_path)
    assert code == 0
    assert "GRF is 110% of the weight in the median: see that" in " ".join(out.split())


def test_a_calibration_that_failed_is_not_applied(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    failed = tmp_path / "failed.yaml"
    failed.write_text(
        calibrated.read_text()
        .replace("verdict: PASS", "verdict: FAIL")
        .replace("verdict: WARN", "verdict: FAIL")
    )
    code, _, error = shoecal("apply", simulated, "--calibration", failed, "--out", tmp_path / "o")
    assert code == 1
    assert "failed its checks" in error
    assert not (tmp_path / "o").exists()
