from __future__ import annotations

from pathlib import Path

from core.report.pages import read
from shoecal_core.estimation.comparison import read_truths
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.report import calibration_page, calibration_report
from shoecal_core.report.calibration.session_report import SNAPSHOTS, session_content
from shoecal_core.report.quantities import true_minus


def test_a_session_is_reported_against_its_model(
    session: Session, outcome: CalibrationOutcome, tmp_path: Path
) -> None:
    path = tmp_path / "report.html"
    calibration_report(path, session_content(session, outcome, timing={"solve": 1.5}))
    text = read(path.read_text(encoding="utf-8")).text
    assert "Calibration of nao_shoe on nao" in text
    assert outcome.calibration.verdict in text
    for reason in outcome.calibration.reasons:
        assert true_minus(reason.removeprefix("WARN: ").removeprefix("FAIL: ")) in text
    assert "are simulated" in text
    assert "training runs: 1, 2; test runs: 3" in text
    assert "1.5 s" in text
    assert "Errors are counted against the model" in text


def test_what_to_plan_with_comes_first(session: Session, outcome: CalibrationOutcome) -> None:
    keys = calibration_page(session_content(session, outcome)).key_figures
    assert [key.label for key in keys[:5]] == [
        "expected CoP error, both feet", "expected CoP error, left foot",
        "expected CoP error, right foot", "CoP error against the model",
        "GRF error against the model",
    ]  # fmt: skip


def test_truths_are_used_only_when_given(session: Session, outcome: CalibrationOutcome) -> None:
    truths = read_truths(session, outcome.data)
    assert session_content(session, outcome, truths=truths).has_truth
    assert not session_content(session, outcome).has_truth
    assert not session_content(session, outcome, truths={1: truths[1]}).has_truth


def test_a_session_from_hardware_is_not_called_simulated(
    session: Session, outcome: CalibrationOutcome
) -> None:
    folder = session.truth_path(1).parent
    hidden = folder.rename(folder.with_name("elsewhere"))
    try:
        lines = session_content(session, outcome).provenance
    finally:
        hidden.rename(folder)
    assert not any("are simulated" in line for line in lines)
    assert any("hardware" in line for line in lines)


def test_snapshots_span_the_run(session: Session, outcome: CalibrationOutcome) -> None:
    for run in session_content(session, outcome).runs:
        assert len(run.snapshot_time) == SNAPSHOTS
        time = run.stances[0].stance.time
        assert run.snapshot_time[0] == time[0]
        assert run.snapshot_time[-1] == time[-1]
