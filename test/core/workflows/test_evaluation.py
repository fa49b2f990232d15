"""Which runs are new to a calibration, and which calibrations belong to a session."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.report.sessions import swaying_session
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.estimation.calibration import Calibration, save_calibration
from shoecal_core.estimation.run_errors import errors_of
from shoecal_core.files import sha256
from shoecal_core.recording.session import Session
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workflows.evaluation import (
    MEASURED,
    MODELLED,
    REFERENCE,
    TRUTH,
    evaluate_session,
    load_calibration_of,
    sets_for,
    version_note,
)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Three runs, of which the session marks 1 and 2 to train."""
    return swaying_session(tmp_path_factory.mktemp("swaying") / "session")


@pytest.fixture
def calibration(session: Session) -> Calibration:
    count = len(session.shoe.names)
    return Calibration(
        id="self-1", source="self", made_ns=1, robot=session.robot, shoe=session.shoe.name,
        robot_hash="", shoe_hash=session.shoe.digest, channels=session.shoe.names,
        parameters=ChannelParameters(np.full(count, 10.0), np.zeros(count)), covariance=None,
        corrections=(), weight=50.0, time_offset=0.0, temperature=float("nan"), verdict="PASS",
        reasons=(),
    )  # fmt: skip


def fitted_to(calibration: Calibration, session: Session, *runs: int) -> Calibration:
    digests = tuple(sha256(entry.path) for entry in session.runs if entry.run in runs)
    return replace(calibration, fitted_runs=digests)


def test_runs_it_was_fitted_to_train_whatever_the_session_marks(
    session: Session, calibration: Calibration
) -> None:
    assert sets_for(session, fitted_to(calibration, session, 2, 3), (), ()) == ((2, 3), (1,))


def test_of_another_session_every_run_is_a_test(session: Session, calibration: Calibration) -> None:
    elsewhere = replace(calibration, fitted_runs=("0" * 64,))
    assert sets_for(session, elsewhere, (), ()) == ((), (1, 2, 3))


def test_a_manual_calibration_was_fitted_to_no_run(
    session: Session, calibration: Calibration
) -> None:
    assert sets_for(session, replace(calibration, source="manual"), (), ()) == ((), (1, 2, 3))


def test_one_that_does_not_say_goes_by_the_session_s_marks(
    session: Session, calibration: Calibration
) -> None:
    assert sets_for(session, calibration, (), ()) == ((1, 2), (3,))


def test_a_run_it_was_fitted_to_is_no_test(session: Session, calibration: Calibration) -> None:
    fitted = fitted_to(calibration, session, 1, 2)
    with pytest.raises(FileError, match=r"was fitted to run\(s\) 2: none of them is a test"):
        sets_for(session, fitted, (1,), (2, 3))
    assert sets_for(session, fitted, (1, 2), (3,)) == ((1, 2), (3,))


def test_runs_that_are_not_there(
    session: Session, calibration: Calibration, tmp_path: Path
) -> None:
    with pytest.raises(FileError, match="has no run 7"):
        sets_for(session, calibration, (), (7,))
    empty = Session.create(
        tmp_path / "empty", session.robot_yaml, session.robot_urdf, session.folder / "shoe.yaml"
    )
    with pytest.raises(FileError, match="has no finished run; record one"):
        sets_for(empty, calibration, (), ())


@pytest.mark.parametrize(
    ("changes", "cure"),
    [
        ({"shoe": "boot"}, "is of shoe 'boot'.* was recorded on 'nao_shoe'; name a calibration"),
        ({"robot": "atlas"}, "is of robot 'atlas'.* is of 'nao'; name a calibration"),
        ({"channels": tuple("abcdefgh")}, "with channels a, b"),
    ],
)
def test_a_calibration_of_something_else_is_refused(
    session: Session,
    calibration: Calibration,
    tmp_path: Path,
    changes: dict[str, str],
    cure: str,
) -> None:
    path = tmp_path / "other.yaml"
    save_calibration(replace(calibration, **changes), path)  # type: ignore[arg-type]
    with pytest.raises(ShoecalError, match=cure) as refused:
        load_calibration_of(path, session)
    assert str(refused.value).startswith(str(path))


def test_another_version_of_the_shoe_s_file_is_told(
    session: Session, calibration: Calibration, tmp_path: Path
) -> None:
    assert version_note(calibration, session) == ""
    path = tmp_path / "older.yaml"
    save_calibration(replace(calibration, shoe_hash="1" * 64), path)
    note = version_note(load_calibration_of(path, session), session)
    assert "another version of the file of shoe 'nao_shoe'" in note


@pytest.mark.parametrize("factor", [1e-6, 1e3])
def test_gains_of_another_unit_are_told_as_such(
    session: Session, calibration: Calibration, factor: float
) -> None:
    """Counts for volts: neither zeros, nor weight, nor model are wrong."""
    own = calibration.parameters
    other = replace(calibration, parameters=replace(own, gain=factor * own.gain))
    verdict = evaluate_session(session, other).verdict
    (reason,) = verdict.reasons
    assert verdict.verdict == "FAIL"
    assert "gains are of readings in another unit than these, which are in V" in reason


def test_everything_known_stands_beside_each_other(
    session: Session, calibration: Calibration
) -> None:
    """The session's model and truth agree; a reference twice as high reads twice as much."""
    doubled = replace(
        calibration,
        parameters=ChannelParameters(2.0 * calibration.parameters.gain, np.zeros(8)),
    )
    runs = evaluate_session(session, calibration, doubled).runs
    assert [(one.run, one.set) for one in runs] == [(1, "train"), (2, "train"), (3, "test")]
    assert errors_of(runs, MODELLED, TRUTH).grf.mean < 1e-9
    assert errors_of(runs, MODELLED, TRUTH).cop.mean < 1e-9
    measured, reference = (runs[0].sources[name][0].grf for name in (MEASURED, REFERENCE))
    # What is left is the weight of the plates below the cells, which no gain doubles.
    assert np.ptp(reference - 2.0 * measured) < 1e-9
    assert np.ptp(measured) > 1e-3


def test_without_reference_and_truth_there_is_the_model(
    session: Session, calibration: Calibration, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Session, "truth_path", lambda self, run: self.folder / f"no_{run}")
    (one,) = evaluate_session(session, calibration, None, (), (3,)).runs[-1:]
    assert set(one.sources) == {MEASURED, MODELLED}
