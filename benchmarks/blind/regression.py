"""The regression of a session's residuals on what each effect of the library would add to them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.error_sources.base import Effect, Place, Shape, lower_bounds
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel, make_signal_model
from shoecal_core.error_sources.signals import PARITY, SIGNALS, TILT
from shoecal_core.estimation.fit import fit_parameters
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.residuals import unpack
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.screening.settings import CalibrationSettings


@dataclass(frozen=True)
class Candidate:
    """One form of an effect at a place.

    Attributes:
        effect, place: which and where.
        columns: (R, k) what a unit of each of its sizes adds to the residuals.
        least: (k,) sizes below which it makes no sense.
        parameters: that are chosen with it, those of its form included.
    """

    effect: Effect
    place: Place
    columns: FloatArray
    least: FloatArray
    parameters: int


@dataclass(frozen=True)
class Regression:
    """R residuals of the training runs, each signal in units of what gains and offsets leave.

    Attributes:
        base: (R, p) columns of gains, offsets and constants.
        residuals: (R,).
        candidates: every form of every effect at every place.
    """

    base: FloatArray
    residuals: FloatArray
    candidates: tuple[Candidate, ...]


def make_regression(folder: Path) -> Regression:
    """Read a session and lay out what is fitted."""
    session = Session.open(folder)
    train, test = split_runs(session, (), ())
    data = load_data(session, (*train, *test), CalibrationSettings(), all_readable=False)
    training = data.of([run for run in train if run in data.stances])
    guess = initial_guess(data.shoe, training, weight_row=True)
    fitted = fit_parameters(data.shoe, training, guess, CalibrationSettings())
    settings = SignalSettings()
    samples = data.whole_samples(settings)
    model = make_signal_model(samples, unpack(fitted.vector)[0], settings)
    here = np.isin(samples.run, train)[:, None] & model.mask
    base = model.baseline[: 2 * len(model.parameters.gain)]
    base = np.concatenate((base, _constants(model)))[:, here].T
    residuals = model.residuals[here]
    signal = np.broadcast_to(np.arange(len(SIGNALS)), here.shape)[here]
    scale = _scales(base, residuals, signal)
    candidates = tuple(
        Candidate(
            effect, place, columns / scale[:, None], _least(effect, shape), _parameters(shape)
        )
        for effect in EFFECTS
        for place in effect.places(model)
        for shape in effect.shapes(model, place)
        if (columns := _columns(model, shape)[:, here].T).any()
    )
    return Regression(base / scale[:, None], residuals / scale, candidates)


def _constants(model: SignalModel) -> FloatArray:
    """(4, T, s) constants of signals that no gain or offset moves."""
    signals = np.r_[PARITY, TILT]
    found = np.zeros((len(signals), *model.residuals.shape))
    found[np.arange(len(signals)), :, signals] = 1.0
    return found


def _columns(model: SignalModel, shape: Shape) -> FloatArray:
    """(k, T, s) of a form; one that changes what channels mean counts as what it changes."""
    if shape.signal_model is None:
        return shape.columns
    return np.array([model.residuals - shape.signal_model.residuals])


def _least(effect: Effect, shape: Shape) -> FloatArray:
    """(k,) of a form's sizes; half of what changes the meaning of channels is none."""
    return lower_bounds(effect, shape) if shape.signal_model is None else np.array([0.5])


def _parameters(shape: Shape) -> int:
    return max(1, len(shape.free) + len(shape.fixed)) + (shape.onset is not None)


def _scales(base: FloatArray, residuals: FloatArray, signal: IntArray) -> FloatArray:
    """(R,) deviation that gains and offsets leave of each residual's signal."""
    scale = np.ones(len(residuals))
    for _ in range(3):
        rows = base / scale[:, None]
        left = residuals - base @ np.linalg.lstsq(rows, residuals / scale, rcond=None)[0]
        count = np.maximum(np.bincount(signal), 1)
        scale = np.sqrt(np.maximum(np.bincount(signal, left**2) / count, 1e-24))[signal]
    return scale
