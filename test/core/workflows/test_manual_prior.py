"""A manual calibration as prior: kept unless the data show that the shoes changed."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from shoecal_core import cli
from shoecal_core.estimation.calibration import Calibration, load_calibration
from shoecal_core.estimation.run_errors import errors_by_set
from shoecal_core.recording.session import Session
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.evaluation import MEASURED, TRUTH, evaluate_session
from shoecal_core.workspace import config_dir

TRAIN, TEST = (1, 2, 3, 4, 5), (6, 7)
SEED = 411


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Session, Calibration]:
    """The standard set of a robot as built, and its shoes on the bench."""
    folder = tmp_path_factory.mktemp("prior")
    robot, shoe = config_dir() / "robots" / "nao.yaml", config_dir() / "shoes" / "nao_shoe.yaml"
    for words in (
        ["simulate", robot, shoe, "--motions", "standard", "--seed", SEED, "--out", folder / "s"],
        ["manual", "simulate", "--seed", 5, "--robot-seed", SEED, "--out", folder / "m"],
    ):
        assert cli.main([str(word) for word in words]) == 0
    return Session.open(folder / "s"), load_calibration(folder / "m" / "calibration.yaml")


def foot_errors(session: Session, calibration: Calibration) -> tuple[float, float]:
    """Mean CoP [m] and GRF [N] error of a foot on the test runs, against contact forces."""
    runs = evaluate_session(session, calibration, None, TRAIN[:1], TEST).runs
    found = errors_by_set(runs, MEASURED, TRUTH)["test"]
    cop, grf = ([foot.mean for foot in feet] for feet in (found.foot_cop, found.foot_grf))
    return float(np.mean(cop)), float(np.mean(grf))


SUBSETS = [*combinations(TRAIN, 2), TRAIN]
"""All pairs, where the data say least against the prior, and the whole set."""


@pytest.mark.parametrize("runs", SUBSETS, ids=str)
def test_motion_never_makes_it_worse(
    recorded: tuple[Session, Calibration], runs: tuple[int, ...]
) -> None:
    session, manual = recorded
    cop, grf = foot_errors(session, manual)
    outcome = calibrate_session(session, runs, TEST, manual=manual)
    found_cop, found_grf = foot_errors(session, outcome.calibration)
    assert found_cop <= 1.05 * cop
    assert found_grf <= 1.5 * grf
    assert outcome.calibration.verdict == "PASS", outcome.calibration.reasons


@pytest.mark.parametrize(
    ("gain", "offset", "reported"),
    [(1.0, 2.0, "zeros moved since"), (1.05, 0.0, "and gains, most that of left/front_left by")],
    ids=["zero", "gain"],
)
def test_shoes_that_changed_are_reported_and_calibrated_anew(
    recorded: tuple[Session, Calibration], gain: float, offset: float, reported: str
) -> None:
    """The manual calibration is of a time when one cell was another."""
    session, manual = recorded
    then = ChannelParameters(manual.parameters.gain.copy(), manual.parameters.offset.copy())
    then.gain[0] *= gain
    then.offset[0] += offset
    old = replace(manual, parameters=then)
    outcome = calibrate_session(session, TRAIN, TEST, manual=old)
    assert outcome.calibration.verdict == "WARN"
    assert any(reported in reason for reason in outcome.calibration.reasons)
    before, after = foot_errors(session, old), foot_errors(session, outcome.calibration)
    alone = foot_errors(session, calibrate_session(session, TRAIN, TEST).calibration)
    for quantity in (0, 1):
        assert after[quantity] < 0.9 * before[quantity]
        assert after[quantity] < 1.2 * alone[quantity], "about as good as without a prior"
