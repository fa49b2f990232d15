"""A real humanoid's ankle sensors: fitted on two trials, better on the third."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from shoecal_core.estimation.series import errors, measured_series, modelled_series
from shoecal_core.parameter_file import load_settings
from shoecal_core.recording.imports.csv_import import import_csv
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.wrench import ChannelParameters
from shoecal_core.workflows.calibrate import calibrate_session

IMPORTS = Path(__file__).resolve().parents[3] / "config" / "imports"
REAL = os.environ.get("SHOECAL_REAL_DATA", "")


@pytest.mark.skipif(not REAL, reason="SHOECAL_REAL_DATA names no folder of real recordings")
@pytest.mark.parametrize(("train", "test"), [((1, 2), 3), ((2, 3), 1)])
def test_the_held_out_trial_gets_better(tmp_path: Path, train: tuple[int, ...], test: int) -> None:
    session = import_csv(IMPORTS / "reemc.yaml", Path(REAL) / "reemc", tmp_path / "session")
    settings = load_settings(
        CalibrationSettings, IMPORTS / "reemc_calibrator.yaml", "calibrator", "calibration"
    )
    outcome = calibrate_session(session, train, (test,), settings, rezero=True)
    count = len(outcome.data.shoe.names)
    raw = Sensing(outcome.data.shoe, ChannelParameters(np.ones(count), np.zeros(count)))
    before = errors(
        [(measured_series(raw, one), modelled_series(one)) for one in outcome.data.of((test,))]
    )
    after = outcome.modelled["self_calibration"]["test"]
    assert after.grf.mean < 0.6 * before.grf.mean
    # The walk's model is the limit of the CoP, and the weight of this robot is not known.
    assert after.cop.mean < 1.1 * before.cop.mean
    assert outcome.calibration.verdict == "WARN"
    assert (
        "by the data sheets of its sensors the robot weighs 77." in outcome.calibration.reasons[0]
    )
