"""What a diagnosis answers to recordings that are not as they should be."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.rewritten import Change, kept, resampled, rewritten, shifted
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.diagnose import diagnose
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import ROBOT, SHOE, Session
from shoecal_core.samples.samples import Samples

SETTINGS = DiagnosisSettings()


def changed_samples(session: Session, folder: Path, change: Change, runs: int = 3) -> Samples:
    numbers = range(1, runs + 1)
    made = rewritten(session, folder / "s", numbers, change)
    return load_data(made, numbers, all_readable=False).whole_samples(SETTINGS)


def as_it_is(run: Run) -> Run:
    return run


@pytest.mark.parametrize("file", [ROBOT, SHOE])
def test_another_robot_or_shoe(standard_session: Session, tmp_path: Path, file: str) -> None:
    shutil.copytree(standard_session.folder, tmp_path / "s")
    path = tmp_path / "s" / file
    path.write_text(path.read_text() + "# another one\n")
    with pytest.raises(ShoecalError, match=f"no run can be used.*{file}"):
        diagnose(Session.open(tmp_path / "s"))


def test_one_run_alone(standard_session: Session) -> None:
    with pytest.raises(ShoecalError, match="record at least two double supports"):
        diagnose(standard_session, [1])


def test_one_double_support_alone(standard_session: Session) -> None:
    """Whatever is wrong there, gains and offsets can imitate it."""
    entries = standard_session.runs
    first = entries[1].info.support
    same = [
        entry.run
        for entry in entries
        if entry.info.support == first and not entry.info.motion.startswith("unload_")
    ]
    assert len(same) > 1
    with pytest.raises(ShoecalError, match="record at least two that differ in yaw"):
        diagnose(standard_session, same)


def test_a_robot_that_stands_still(standard_session: Session, tmp_path: Path) -> None:
    def still(run: Run) -> Run:
        rng = np.random.default_rng(run.info.run)
        joints, readings = run.joints, run.readings
        noise = 1e-5 * rng.normal(size=readings.value.shape)
        return replace(
            run,
            joints=replace(joints, position=np.tile(joints.position[:1], (len(joints.time), 1))),
            readings=replace(readings, value=readings.value[:1] + noise),
        )

    session = rewritten(standard_session, tmp_path / "s", (1, 2, 3), still)
    with pytest.raises(ShoecalError, match="robot moves"):
        diagnose(session)


def test_what_was_not_recorded_is_told(standard_session: Session, tmp_path: Path) -> None:
    notes = " ".join(changed_samples(standard_session, tmp_path, as_it_is).notes)
    for missing in ("/imu", "temperature", "efforts"):
        assert missing in notes


@pytest.mark.parametrize(("rate", "duration"), [(10.0, 30.0), (1000.0, 8.0)])
def test_other_rates(
    standard_session: Session, tmp_path: Path, rate: float, duration: float
) -> None:
    usual = load_data(standard_session, (1, 2)).whole_samples(SETTINGS)
    found = changed_samples(
        standard_session, tmp_path, lambda run: resampled(run, rate, duration), 2
    )
    assert len(found.run) > 0.75 * 2 * duration * SETTINGS.rate_hz
    early = usual.time < duration - 1.0
    for run in (1, 2):
        theirs, ours = (one.run == run for one in (usual, found))
        times = usual.time[theirs & early]
        for axis in (0, 1):
            again = np.interp(times, found.time[ours], found.cop[ours][:, axis])
            np.testing.assert_allclose(again, usual.cop[theirs & early][:, axis], atol=1e-3)


def test_a_gap_in_time_is_left_out(standard_session: Session, tmp_path: Path) -> None:
    def gap(run: Run) -> Run:
        return kept(run, lambda time: (time < 10.0) | (time > 15.0))

    found = changed_samples(standard_session, tmp_path, gap, 2)
    assert not ((found.time > 10.2) & (found.time < 14.8)).any()
    assert (found.time > 15.0).any()
    before, after = (found.run == 1) & (found.time < 10.0), (found.run == 1) & (found.time > 15.0)
    assert set(found.segment[before]).isdisjoint(found.segment[after])


@pytest.mark.parametrize("late", [3.0, -4.0])
def test_clocks_that_disagree(standard_session: Session, tmp_path: Path, late: float) -> None:
    with pytest.raises(ShoecalError, match=r"joints and readings are [34]\.\d s apart"):
        changed_samples(standard_session, tmp_path, lambda run: shifted(run, late))


def test_a_late_device_is_no_disagreement(standard_session: Session, tmp_path: Path) -> None:
    found = changed_samples(standard_session, tmp_path, lambda run: shifted(run, 0.2), 2)
    assert found.runs == (1, 2)


def test_joints_that_broke_off_are_no_disagreement(
    standard_session: Session, tmp_path: Path
) -> None:
    def broken(run: Run) -> Run:
        joints = run.joints
        early = joints.time < 0.6 * joints.time[-1]
        return replace(
            run, joints=replace(joints, time=joints.time[early], position=joints.position[early],
                                effort=None)
        )  # fmt: skip

    found = changed_samples(standard_session, tmp_path, broken, 2)
    assert found.runs == (1, 2)


def test_a_run_of_nan(standard_session: Session, tmp_path: Path) -> None:
    def silent(run: Run) -> Run:
        if run.info.run != 2:
            return run
        readings = run.readings
        return replace(run, readings=replace(readings, value=np.full_like(readings.value, np.nan)))

    found = changed_samples(standard_session, tmp_path, silent)
    assert found.runs == (1, 3)
    assert any("run 2 is left out" in note for note in found.notes)
    assert np.isfinite(first_parameters(found, (1, 3)).gain).all()


def test_walking_without_a_base_pose(standard_session: Session, tmp_path: Path) -> None:
    def nowhere(run: Run) -> Run:
        return replace(run, info=replace(run.info, support=None))

    with pytest.raises(ShoecalError, match="names no double support and has no /base_pose"):
        changed_samples(standard_session, tmp_path, nowhere, 2)
