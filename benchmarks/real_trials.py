"""Zeros, weight, gains and verdicts over all trials of the REEM-C.

Every trial is held out once: gains are fitted to the others, and the GRF of the trial is predicted
with their mean zeros and with its own.
"""

from __future__ import annotations

from collections.abc import Sequence

from pages import Row
from shoecal_core.estimation.axes import sideways_axes
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.weight import weigh
from shoecal_core.recording.session import Session
from shoecal_core.samples.zeros import NORMAL_95, data_sheet
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.six_axis.sideways import AXES
from shoecal_core.shoe.shoe import FEET
from shoecal_core.workflows.calibrate import calibrate_session

NUMBERS = (1, 3, 4)
"""Trials that gains are fitted to, besides all."""


def tables(session: Session, settings: CalibrationSettings) -> dict[str, Sequence[Row]]:
    """By the sections of docs/evidence/real-robots.md."""
    runs = [entry.run for entry in session.runs]
    names = {entry.run: f"{entry.run} {entry.info.motion}" for entry in session.runs}
    held = {run: _held_out(session, settings, run, runs) for run in runs}
    fitted = [
        calibrate_session(session, runs[:count], settings=settings, rezero=True)
        for count in (*NUMBERS, len(runs))
    ]
    everything = fitted[-1]
    weights = [
        weigh(session.shoe, {run: session.read(run).readings.value}, everything.data.zeros)
        for run in runs
    ]
    zeros = [
        {
            "trial": names[run],
            **_zeros(run, held[run][0], everything),
            "kg": "-" if weighed is None else f"{weighed.kg:.2f}",
        }
        for run, weighed in zip(runs, weights, strict=True)
    ]
    together = everything.data.weighed
    assert together is not None
    low, high = together.ci95
    all_trials: Row = dict.fromkeys(zeros[0], "") | {
        "trial": "all",
        "kg": f"{together.kg:.1f} ({low:.1f} to {high:.1f})",
    }
    return {
        "zeros": [*zeros, all_trials],
        "gains": [_gains(name, fitted) for name in session.shoe.names],
        "held-out": [{"held out": names[run], **_errors(*held[run])} for run in runs],
        "axes": _axes(everything, runs),
    }


def _held_out(
    session: Session, settings: CalibrationSettings, run: int, runs: Sequence[int]
) -> tuple[CalibrationOutcome, CalibrationOutcome]:
    """Judged with the mean zeros of the others, and with its own."""
    train = [other for other in runs if other != run]
    one_set, own = (
        calibrate_session(session, train, (run,), settings, rezero=rezero)
        for rezero in (False, True)
    )
    return one_set, own


def _zeros(
    run: int, one_set: CalibrationOutcome, everything: CalibrationOutcome
) -> dict[str, object]:
    """What each foot shows in the air, by the data sheets and by the others' zeros [N]."""
    data = everything.data
    cells: dict[str, object] = {}
    for foot, side in enumerate(FEET):
        law = data_sheet(data.shoe, foot)
        (zero,) = [one for one in data.zeros if (one.run, one.foot) == (run, foot)]
        assert law is not None
        shown = zero.wrench(data.shoe, law)[:, 0]
        force, std = zero.force(data.shoe, law)
        swings = [shown[zero.phase == one].mean() - force for one in range(zero.phase.max() + 1)]
        others = zero.force(data.shoe, one_set.calibration.parameters)[0]
        cells[f"{side} zero"] = f"{force:.1f} ± {NORMAL_95 * std:.1f}"
        cells[f"{side} swings"] = f"{min(swings):+.1f} to {max(swings):+.1f}"
        cells[f"{side}, others leave"] = f"{others:+.1f}"
    return cells


def _gains(name: str, fitted: Sequence[CalibrationOutcome]) -> Row:
    """A channel's gain over its data sheet by the number of trials fitted."""
    cells = {"channel": name}
    for outcome in fitted:
        index = outcome.data.shoe.index(name)
        gain = outcome.calibration.parameters.gain[index]
        half = NORMAL_95 * float(outcome.assessment.covariance[index, index]) ** 0.5
        cells[f"{len(outcome.train)} trials"] = f"{gain:.2f} ± {half:.2f}"
    return cells


def _errors(one_set: CalibrationOutcome, own: CalibrationOutcome) -> Row:
    first, error = (one.modelled["self_calibration"]["test"] for one in (one_set, own))
    left, right = (1e3 * one.mean for one in error.foot_cop)
    limit = own.limits["test"]
    return {
        "GRF, one set (N)": f"{first.grf.mean:.1f}",
        "its verdict": one_set.calibration.verdict,
        "GRF, own zeros (N)": f"{error.grf.mean:.1f}",
        "verdict": own.calibration.verdict,
        "CoP (mm)": f"{1e3 * error.cop.mean:.0f} ({left:.0f}, {right:.0f})",
        "at best (mm)": f"{1e3 * limit.cop[0]:.0f}",
        "r": f"{limit.together[0]:.2f}",
    }


def _axes(everything: CalibrationOutcome, runs: Sequence[int]) -> list[Row]:
    """Slopes of the sideways channels on mass times acceleration."""
    return [
        {
            "channel": f"{FEET[one.foot]}/{name}",
            "slope": f"{one.slope[index, index]:+.2f} ± {one.half[index, index]:.2f}",
            "finding": "reversed" if name in one.reversed else "open",
        }
        for one in sideways_axes(everything.data.shoe, everything.data.of(runs))
        for index, name in enumerate(AXES)
    ]
