"""Whether a calibration's stated uncertainties hold what it truly got wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.series import truth_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing

STEP = 100
"""Every so many samples of a test run: errors change slowly."""
COPS = ("CoP", "left CoP", "right CoP")
WHAT = ("gain", "time offset", "GRF", *COPS)


@dataclass(frozen=True)
class Held:
    """One calibration against the truth; the CoP corrections of a manual prior count.

    Attributes:
        ratios: by quantity, errors over their standard deviations; CoPs along x and y apart.
        expected, actual: root mean square CoP error of both feet, left, right [m].
    """

    ratios: Mapping[str, FloatArray]
    expected: FloatArray
    actual: FloatArray


def hold(judged: Session, outcome: CalibrationOutcome, true_gain: FloatArray) -> Held:
    """Hold an outcome against the truth.

    Args:
        judged: whose test runs' contact forces count: the one calibrated, or one that differs from
            it in noise alone.
        outcome: of calibrating.
        true_gain: (n,).
    """
    stages, errors = outcome.stages, outcome.assessment.error_model
    data = load_data(judged, outcome.test, CalibrationSettings())
    parameters, count = stages.parameters, len(true_gain)
    std = np.sqrt(np.diag(outcome.assessment.covariance))
    ratios: dict[str, list[FloatArray]] = {name: [] for name in WHAT}
    ratios["gain"].append((parameters.gain - true_gain) / std[:count])
    ratios["time offset"].append(np.array([stages.time_offset / std[-1]]))
    sensing = Sensing(outcome.data.shoe, parameters, stages.corrections)
    lengths: dict[str, list[tuple[FloatArray, FloatArray]]] = {name: [] for name in COPS}
    for stance in data.of(outcome.test):
        few = stance.part(slice(None, None, STEP))
        truth = read_truth(judged.truth_path(stance.run), data.runs[stance.run].start_ns)
        true = truth_series(truth, few)
        measured = sensing.measure(few.readings)
        outputs = parameters.outputs(few.readings)
        both = errors.both_feet(outputs, few.support)
        ratios["GRF"].append((measured.total_grf - true.grf) / both.grf)
        lengths["CoP"].append((both.cop, measured.combined_cop(few.support) - true.cop))
        for foot, name in enumerate(COPS[1:]):
            off = measured.cop[:, foot] - true.foot_cop[:, foot]
            lengths[name].append((errors.foot(outputs, foot).cop, off))
    for name in COPS:
        ratios[name] += [(off / spread).ravel() for spread, off in lengths[name]]
    expected, actual = (
        np.array([_rms(np.concatenate([pair[side] for pair in lengths[name]])) for name in COPS])
        for side in (0, 1)
    )
    joined = {name: np.concatenate(parts) for name, parts in ratios.items()}
    finite = {name: values[np.isfinite(values)] for name, values in joined.items()}
    return Held(finite, expected, actual)


def _rms(vectors: FloatArray) -> float:
    """Root mean square length of vectors (T, 2) [m]."""
    return float(np.sqrt(np.nanmean((vectors**2).sum(axis=1))))
