"""One session calibrated by default, against contact forces."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from accuracy_sessions import Case
from held import Held, hold
from held_budget import hold_budget
from population import nao
from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.run_errors import errors_by_set
from shoecal_core.estimation.series import Errors
from shoecal_core.manual.calibrate import calibrate_manually
from shoecal_core.recording.session import Session
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.evaluation import MEASURED, TRUTH, evaluate_session
from shoecal_core.workflows.simulated_manual import simulate_manual
from true_sources import read_drawn

FAILED = "FAIL"
REFUSED, UNRECORDED = "refused", "not recorded"


@dataclass(frozen=True)
class Result:
    """What came of one session.

    Attributes:
        case: which one.
        verdict: of the calibration; REFUSED where there is none, UNRECORDED without a session.
        reason: of a verdict that lets nothing be written; else empty.
        seconds: of processor time that calibrating took.
        errors: on the test runs, as `shoecal evaluate` reports them.
        gain_errors: (n,) found over true gain, minus 1.
        held: stated uncertainties against the truth.
        budget: by source, (3,) whether its true share of the CoP error is inside its interval.
    """

    case: Case
    verdict: str
    reason: str = ""
    seconds: float = float("nan")
    errors: Errors | None = None
    gain_errors: FloatArray | None = None
    held: Held | None = None
    budget: Mapping[str, BoolArray] = field(default_factory=dict)


def measure(case: Case) -> Result:
    """Calibrate a session that has been made.

    Noise of single readings is no error of the calibration: where readings are noisy, the same
    motions are judged as they are read without.
    """
    session = Session.open(case.folder)
    train, test = case.sets(session)
    manual = _manual(case) if case.manual else None
    begin = time.process_time()
    try:
        outcome = calibrate_session(session, train, test, manual=manual)
    except ShoecalError as error:
        return Result(case, REFUSED, str(error).replace(f"{case.folder}: ", ""))
    seconds = time.process_time() - begin
    calibration = outcome.calibration
    judged = Session.open(case.quiet.folder)
    runs = evaluate_session(judged, calibration, train=train, test=test).runs
    drawn = read_drawn(session)
    true_gain = np.array([drawn["gain"][name] for name in calibration.channels])
    return Result(
        case=case,
        verdict=calibration.verdict,
        reason="; ".join(calibration.reasons) if calibration.verdict == FAILED else "",
        seconds=seconds,
        errors=errors_by_set(runs, MEASURED, TRUTH)["test"],
        gain_errors=calibration.parameters.gain / true_gain - 1.0,
        held=hold(judged, outcome, true_gain) if outcome.test else None,
        budget=hold_budget(session, outcome, case.load_reality()),
    )


def _manual(case: Case) -> Calibration:
    """A manual calibration of a case's shoes, on the simulated rig."""
    robot, shoe = nao()
    cells, loads = simulate_manual(shoe, case.load_reality(), case.seed, case.seed)
    return calibrate_manually(shoe, robot, cells, loads).calibration
