"""Calibrating a session of the simulator: figures, result file and report."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from shoecal_core.cli.calibrate_command import to_json
from shoecal_core.cli.program import main
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.estimation.fit import self_calibrate
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.session_data import load_data
from shoecal_core.estimation.uncertainty.stated_error import StatedError, turns_to
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.assessment_tables import source_name
from shoecal_core.report.calibration.report import calibration_report
from shoecal_core.report.calibration.session_report import session_content
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.workflows.calibrate import calibrate_session

TRAIN, TEST = range(1, 7), (7, 8)


@pytest.fixture(scope="module")
def outcome(standard_session: Session) -> CalibrationOutcome:
    """The standard set of a robot that is as its files say."""
    return calibrate_session(standard_session, TRAIN, TEST)


def test_gains_are_those_of_the_simulated_cells(
    standard_session: Session, outcome: CalibrationOutcome
) -> None:
    drawn = yaml.safe_load((standard_session.truth_path(1).parent / "reality.yaml").read_text())
    true = np.array([drawn["gain"][name] for name in outcome.data.shoe.names])
    np.testing.assert_allclose(outcome.calibration.parameters.gain, true, rtol=0.03)


def test_residuals_are_small_on_runs_that_were_not_fitted(outcome: CalibrationOutcome) -> None:
    for found in outcome.modelled["self_calibration"].values():
        assert found.grf.mean < 0.5
        assert found.cop.mean < 1e-3
    guess, fitted = (outcome.modelled[one]["test"] for one in ("initial_guess", "self_calibration"))
    assert fitted.cop.mean < guess.cop.mean
    assert outcome.calibration.verdict != "FAIL", outcome.calibration.reasons


def test_it_is_fitted_with_all_that_may_be_wrong(outcome: CalibrationOutcome) -> None:
    joint = outcome.joint
    assert joint is not None
    assert joint.cost < joint.initial_cost
    np.testing.assert_array_equal(outcome.calibration.parameters.gain, joint.parameters.gain)
    np.testing.assert_array_equal(outcome.calibration.columns, joint.shoe.columns)
    assert outcome.calibration.corrections == ()
    effects = {one.deviation.effect for one in joint.deviations}
    assert {"joint_offset", "backlash", "cell_position", "plates", "support"} <= effects


def test_its_file_states_the_errors_of_the_report(
    outcome: CalibrationOutcome, tmp_path: Path
) -> None:
    """At readings of a test run, foot by foot and for both."""
    save_calibration(outcome.calibration, tmp_path / "calibration.yaml")
    calibration = load_calibration(tmp_path / "calibration.yaml")
    session, data = outcome.data.session, outcome.data
    filed = StatedError.of_calibration(calibration, data.robot, session.shoe, Tolerances())
    assert filed is not None
    errors = outcome.assessment.error_model
    (stance, *_) = data.of(TEST)
    readings = stance.readings[::500]
    outputs = calibration.parameters.outputs(readings)
    sample = filed.at(readings)
    for stated, spread in (
        (sample.foot(0), errors.foot(outputs, 0)),
        (sample.foot(1), errors.foot(outputs, 1)),
        (sample.both(turns_to(stance.support)), errors.both_feet(outputs, stance.support)),
    ):
        found = np.sqrt(np.diagonal(stated.output_covariance, axis1=1, axis2=2))
        np.testing.assert_allclose(found, np.column_stack((spread.grf, spread.cop)), rtol=1e-6)


def test_figures_for_machines(outcome: CalibrationOutcome) -> None:
    figures = json.loads(json.dumps(to_json(outcome), allow_nan=False))
    joint, budget = outcome.joint, outcome.assessment.budget
    assert joint is not None
    assert budget is not None
    assert len(figures["deviations"]) == len(joint.deviations)
    assert set(figures["deviations"][0]) == {
        "effect", "location", "component", "run", "unit", "value", "std", "as_built_std",
    }  # fmt: skip
    for one in figures["deviations"]:
        assert 0.0 < one["std"] <= one["as_built_std"] * (1.0 + 1e-6)
    rows = figures["assessment"]["budget"]
    assert [one["source"] for one in rows] == [one.effect for one in budget.sources]
    assert sum(one["cop_share"] for one in rows) == pytest.approx(1.0)
    expected = figures["assessment"]["expected_error"]
    squares = np.sum([np.square(one["cop_mm"]) for one in rows], axis=0)
    totals = [expected[name]["cop_std_mm"] for name in ("both", "left", "right")]
    np.testing.assert_allclose(np.sqrt(squares), totals, rtol=1e-6)


def test_the_report_has_the_budget(
    standard_session: Session, outcome: CalibrationOutcome, tmp_path: Path
) -> None:
    path = tmp_path / "report.html"
    calibration_report(path, session_content(standard_session, outcome))
    html = path.read_text()
    budget = outcome.assessment.budget
    assert budget is not None
    assert "What would help most" in html
    assert "Error sources of the CoP, both feet together" in html
    for one in budget.sources[:3]:
        assert source_name(one.effect) in html.replace("&#x27;", "'")


def test_the_papers_own_method_is_guess_least_squares_and_correction(
    standard_session: Session, outcome: CalibrationOutcome, tmp_path: Path
) -> None:
    settings = CalibrationSettings(method="paper")
    own = self_calibrate(outcome.data.shoe, _training(standard_session, settings), settings)
    written, figures = tmp_path / "calibration.yaml", tmp_path / "figures.json"
    code = main([
        "calibrate", str(standard_session.folder), "--method", "paper",
        "--train", "1,2,3,4,5,6", "--test", "7,8",
        "--out", str(written), "--json", str(figures),
    ])  # fmt: skip
    assert code == 0
    said = json.loads(figures.read_text())
    assert said["method"] == "paper"
    assert said["deviations"] == []
    gains = [one["gain"] for one in said["channels"].values()]
    np.testing.assert_allclose(gains, own.parameters.gain, rtol=1e-4)
    assert len(load_calibration(written).corrections) == len(own.corrections)

    assert to_json(outcome)["method"] == "joint"


def _training(session: Session, settings: CalibrationSettings) -> list[Stance]:
    return load_data(session, (*TRAIN, *TEST), settings).of(TRAIN)
