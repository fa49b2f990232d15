"""What a calibration's verdict rests on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from core.estimation import synthetic
from core.robot import robots
from core.shoe import shoes
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.fit import self_calibrate
from shoecal_core.estimation.series import errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import SessionData
from shoecal_core.estimation.uncertainty.assessment import assess
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding, Verdict
from shoecal_core.workflows import calibrate as pipeline

SETTINGS = CalibrationSettings()


def verdict(supports: Sequence[DoubleSupport], findings: Sequence[Finding] = ()) -> Verdict:
    """Of the NAO on its shoes, calibrated in some supports."""
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    rng = np.random.default_rng(3)
    truth = synthetic.truth(shoe, rng)
    runs = synthetic.stances(shoe, truth, rng, supports, count=1200, weight=robot.weight)
    stages = self_calibrate(shoe, runs, SETTINGS)
    data = SessionData(
        session=Session(Path("none"), "nao", "nao_shoe", None, []),
        kinematics=Kinematics(robot),
        shoe=shoe,
        stances={run.run: (run,) for run in runs},
        runs={},
        recorded={},
        aligned={},
    )
    pairs = [(measured_series(stages.sensing, run), modelled_series(run)) for run in runs]
    modelled = {"train": errors(pairs)}
    assessment = assess(robot, stages, None, runs, SETTINGS, Tolerances())
    return pipeline._verdict(
        data, stages, modelled, {"train": None}, list(findings), assessment, np.inf
    )


def test_three_supports_of_other_yaw_pass() -> None:
    assert verdict(synthetic.SUPPORTS[:3]).verdict == "PASS"


@pytest.mark.parametrize(
    "supports", [synthetic.SUPPORTS[:2], synthetic.STRAIGHT], ids=["two", "straight"]
)
def test_supports_that_leave_the_feet_s_shares_open_are_told(
    supports: Sequence[DoubleSupport],
) -> None:
    """Both feet together look right there, so the residuals do not tell."""
    found = verdict(supports)
    assert found.verdict == "FAIL"
    assert "the CoP is expected to be off by" in found.reasons[0]
    assert "add a double support: right foot at dx" in found.reasons[0]
    assert "of 14 directions, but not: the offsets of" in found.reasons[1]
    assert sum(reason.count("add a double support") for reason in found.reasons) == 1


def test_what_was_found_before_the_fit_counts() -> None:
    found = verdict(synthetic.SUPPORTS[:3], [Finding("FAIL", "left/front_left never changes")])
    assert found.verdict == "FAIL"
