"""Recordings of a robot that hangs: zeros that the fit uses, and zeros that have moved."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import WREN, WREN_SHOE, Run
from shoecal_core import cli
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint import known_zeros
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.info import HANGING
from shoecal_core.recording.session import Session
from shoecal_core.samples.zeros import Zero
from shoecal_core.shoe.wrench import ChannelParameters, foot_wrenches
from shoecal_core.workflows.calibrate import calibrate_session

NOISE_MV = 2e-3


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two double supports, and each foot lifted once, which shows what it reads in the air."""
    out = tmp_path_factory.mktemp("hanging") / "standing"
    words = ["simulate", WREN, WREN_SHOE, "--seed", 2, "--out", out]
    words += ["--motions", "landmarks,reversed,unload_left,unload_right"]
    assert cli.main([str(word) for word in words]) == 0
    return out


def in_the_air(session: Session) -> FloatArray:
    """(n,) readings of channels whose foot hangs."""
    zeros = load_data(session).zeros
    assert {zero.foot for zero in zeros} == {0, 1}
    found = np.zeros(len(session.shoe.names))
    for zero in zeros:
        own = session.shoe.of_foot(zero.foot)
        found[own] = zero.reading[own]
    return found


def with_hanging(standing: Path, folder: Path, shift: FloatArray | float = 0.0) -> Session:
    """A copy of a session with a run in which both feet hang, its readings shifted."""
    shutil.copytree(standing, folder)
    session = Session.open(folder)
    first, zeros = session.read(1), in_the_air(session) + shift
    rng = np.random.default_rng(5)
    start = first.start_ns + 10**12
    with session.new_run(HANGING, None) as writer:
        for index in range(500):
            stamp = start + index * 10_000_000
            joints = messages.joint_state(stamp, first.joints.names, first.joints.position[0])
            writer.write(schemas.JOINT_STATES, joints, stamp)
            shown = zeros + NOISE_MV * rng.standard_normal(len(zeros))
            status = np.zeros(len(zeros), dtype=np.uint8)
            volts = messages.shoe_voltages(stamp, index, session.shoe.names, shown, status)
            writer.write(schemas.VOLTAGES, volts, stamp)
    return Session.open(folder)


def test_the_fit_knows_offsets_better_by_it(standing: Path, tmp_path: Path) -> None:
    alone = calibrate_session(Session.open(standing), train=(1, 2))
    session = with_hanging(standing, tmp_path / "session")
    hung = calibrate_session(session, train=(1, 2, 5))
    assert hung.train == (1, 2)
    assert hung.calibration.verdict != "FAIL", hung.calibration.reasons
    count = len(session.shoe.names)
    air = in_the_air(session)
    for foot in (0, 1):
        # What a foot shows in the air, by each calibration.
        off = [
            abs(foot_wrenches(session.shoe, one.calibration.parameters.outputs(air))[foot, 0])
            for one in (alone, hung)
        ]
        assert off[1] < 0.05
        assert off[1] < off[0]
    stds = [np.diag(one.assessment.covariance)[count : 2 * count].sum() for one in (alone, hung)]
    assert stds[1] < stds[0]


def test_zeros_that_moved_are_named(standing: Path, tmp_path: Path, shoecal: Run) -> None:
    alone = calibrate_session(Session.open(standing), train=(1, 2))
    shift = 5.0 / alone.calibration.parameters.gain  # 5 N of each cell
    session = with_hanging(standing, tmp_path / "session", shift)
    outcome = calibrate_session(session, train=(1, 2, 3, 4, 5))
    assert outcome.calibration.verdict == "FAIL"
    assert any("zero" in reason for reason in outcome.calibration.reasons)
    code, told, _ = shoecal("check", session.folder)
    assert "both feet in the air" in told
    assert code in (0, 1)
    code, _, error = shoecal("diagnose", session.folder, "--json", tmp_path / "d.json")
    assert "Traceback" not in error
    assert code in (0, 1)


def test_other_commands_leave_it_out(standing: Path, tmp_path: Path, shoecal: Run) -> None:
    session = with_hanging(standing, tmp_path / "session").folder
    calibration, report = tmp_path / "calibration.yaml", tmp_path / "report.html"
    for words in (
        ("calibrate", session, "--out", calibration, "--report", report),
        ("evaluate", session, "--calibration", calibration),
        ("apply", session, "--calibration", calibration, "--out", tmp_path / "tables"),
        ("check", session, "--report", report),
    ):
        code, _, error = shoecal(*words)
        assert code == 0, (words, error)
    with (tmp_path / "tables" / "run_005.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert len(rows) == 500
    for side in ("left", "right"):
        (grf,) = (name for name in rows[0] if side in name and "grf" in name)
        assert abs(np.mean([float(row[grf]) for row in rows])) < 0.1


def test_rows_are_the_derivatives_of_what_feet_show_in_the_air(standing: Path) -> None:
    shoe = Session.open(standing).shoe
    count = len(shoe.names)
    rng = np.random.default_rng(1)
    parameters = ChannelParameters(rng.normal(5.0, 1.0, count), rng.normal(0.0, 1.0, count))
    reading = rng.normal(0.0, 0.3, (1, count))
    zeros = [Zero(1, foot, np.zeros(1, dtype=np.int64), reading) for foot in (0, 1)]
    known = known_zeros(shoe, zeros, Tolerances())
    rows, target = known.rows(parameters)
    shown = foot_wrenches(shoe, parameters.outputs(reading))[0].reshape(-1)
    np.testing.assert_allclose(target * known.std, shown, atol=1e-12)
    step = 1e-4 * rng.normal(size=2 * count)
    moved = replace(
        parameters, gain=parameters.gain + step[:count], offset=parameters.offset + step[count:]
    )
    after = known.rows(moved)[1]
    np.testing.assert_allclose(after - target, rows @ step, atol=1e-8)
