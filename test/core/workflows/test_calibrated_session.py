"""Calibrating a session of the simulator: figures, result file and report."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from shoecal_core.cli.calibrate_command import to_json
from shoecal_core.estimation.joint import of_joint
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.recording.session import Session
from shoecal_core.report.assessment import source_name
from shoecal_core.report.session_report import write_session_report
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


def test_a_cop_correction_is_fitted_to_what_the_joint_fit_leaves_if_asked_for(
    outcome: CalibrationOutcome,
) -> None:
    joint, stages = outcome.joint, outcome.stages
    assert joint is not None
    bent = [
        replace(one, cop=one.cop + 2.0 * one.cop * np.abs(one.cop))
        for one in outcome.data.of(outcome.train)
    ]
    for size, feet in ((0.0, False), (0.01, True)):
        settings = CalibrationSettings(correction_std_m=size)
        found = of_joint(joint, stages.guess, stages.guess_with_weight, bent, settings)
        assert (len(found.corrections) > 0) == feet


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
    write_session_report(path, standard_session, outcome)
    html = path.read_text()
    budget = outcome.assessment.budget
    assert budget is not None
    assert "What would help most" in html
    assert "Error sources of the CoP, both feet together" in html
    for one in budget.sources[:3]:
        assert source_name(one.effect) in html.replace("&#x27;", "'")
