"""Everything that hypotheses are judged by, made once for a session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.diagnosis.baseline import coarse_noise, fit_baseline
from shoecal_core.diagnosis.hypotheses import Catalogue, make_catalogue
from shoecal_core.diagnosis.prediction import log_predictive, within_tolerance
from shoecal_core.diagnosis.rows import make_rows, transformed
from shoecal_core.diagnosis.scoring import Scored, Scorer
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.spread import WORSE_FORM_LEVELS
from shoecal_core.error_sources.as_built import as_built
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.noise import jolts
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.error_sources.whitening import (
    WhitenedProducts,
    Whitening,
)

LEAST = 1e-24
"""Variance of a signal that is not there."""


@dataclass(frozen=True)
class Workspace:
    """A signal_model under its best parameters, all hypotheses laid out in it, and their sums.

    Attributes:
        signal_model: with gains and offsets fitted to the training runs.
        noise: (s, BANDS) variance of the coefficients of a robot within tolerance.
        catalogue: of hypotheses.
        whitening: by that noise.
        sums: of the training runs.
        scorer: of the training runs; the runs left out are laid out with them.
        train, test: numbers of the runs.
        tolerances: of the robot's tolerance errors.
        built: the fit by which the robot's tolerance errors are as large as they are.
    """

    signal_model: SignalModel
    noise: FloatArray
    catalogue: Catalogue
    whitening: Whitening
    sums: WhitenedProducts
    scorer: Scorer
    train: tuple[int, ...]
    test: tuple[int, ...]
    tolerances: Tolerances
    built: Scored

    def at(self, scored: Scored) -> Workspace:
        """With tolerance errors as an explanation leaves them."""
        return self._with(self.scorer, scored)

    def built_worse(self) -> Workspace:
        """The same for a robot that may be built worse than its tolerances say."""
        own = self.scorer
        scorer = Scorer(own.rows, own.channels, own.withheld, WORSE_FORM_LEVELS)
        return self._with(scorer, scorer.nothing)

    def _with(self, scorer: Scorer, built: Scored) -> Workspace:
        found = replace(self, scorer=scorer, built=built)
        # What does not hang on them stays.
        found.__dict__.update(_fitter=self._fitter, left_of_errors=self.left_of_errors)
        return found

    def calibrated(self, values: FloatArray) -> FloatArray:
        """(..., T, s) what a calibration on the training runs leaves of residuals (..., T, s).

        Gains and offsets make up for what they can; tolerance errors are not known to it.
        """
        kept, fitter = self._fitter
        shape = values.shape
        flat = values.reshape(-1, *shape[-2:])
        rows = self.rows_of(self.train)
        coefficients = self.whitening(flat)[:, rows][:, self.whitening.kept[rows]]
        fitted = coefficients @ fitter.T
        left: FloatArray = flat - np.tensordot(fitted, self.signal_model.baseline[kept], 1)
        return left.reshape(shape)

    @cached_property
    def _fitter(self) -> tuple[IntArray, FloatArray]:
        """Which of the baseline's columns a calibration has, and (b, R) how they are fitted."""
        signal_model = self.signal_model
        kept = np.flatnonzero(signal_model.shared & ~signal_model.built)
        rows = self.rows_of(self.train)
        base = self.whitening(signal_model.baseline[kept])[:, rows][:, self.whitening.kept[rows]]
        return kept, Posterior(base @ base.T, self.sums.precision[kept]).solve(base)

    def predicted(self, scored: Scored, *, bounded: bool) -> float:
        """Logarithm of the probability of the runs left out.

        Args:
            scored: fitted to the others.
            bounded: with tolerance errors that are no larger than tolerances allow.
        """
        known, key = self._predictions, (id(scored), bounded)
        if key not in known:
            used = within_tolerance(scored) if bounded else scored
            known[key] = scored, log_predictive(used)
        return known[key][1]

    @cached_property
    def _predictions(self) -> dict[tuple[int, bool], tuple[Scored, float]]:
        """By the fit, which is kept with it: so long its number is its own."""
        return {}

    def added(self, scored: Scored | None, part: slice = slice(None)) -> FloatArray:
        """(T, s) what an explanation's columns add: all of them, or some of its components."""
        if scored is None or not scored.parts:
            return np.zeros_like(self.signal_model.residuals)
        columns = self.catalogue.columns[list(scored.columns[part])]
        added: FloatArray = np.tensordot(scored.sizes[part], columns, 1)
        return added

    def explained(self, scored: Scored | None) -> tuple[FloatArray, FloatArray]:
        """(T, s) residuals that calibration and explanation leave, (T, s) what the latter adds."""
        added = self.added(scored)
        return self.calibrated(self.signal_model.residuals - added), added

    def without(self, scored: Scored, index: int) -> FloatArray:
        """(T, s) residuals that a calibration leaves with all parts but one."""
        others = self.added(scored) - self.added(scored, scored.own(index))
        return self.calibrated(self.signal_model.residuals - others)

    @cached_property
    def floor(self) -> FloatArray:
        """(s,) RMS that each signal would have on runs left out without the fault: noise, and what
        a calibration leaves of the tolerance errors, as fitted to the training runs but no larger
        than tolerances allow: else a fault that is like some of them would be its own floor.
        """
        rows = self.rows_of(self.test or self.train)
        count = np.maximum(self.signal_model.mask[rows].sum(axis=0), 1)
        errors, left = self.left_of_errors
        known = np.tensordot(within_tolerance(self.built).vector[errors], left, 1)
        spread = self.built.covariance[np.ix_(errors, errors)]
        unknown = np.array([np.sum(one * (spread @ one)) for one in np.moveaxis(left, 2, 0)])
        kept, group = self.whitening.kept[rows], self.whitening.spectrum.group[rows]
        noise = np.where(kept, self._quiet.ravel()[group], 0.0).sum(axis=0)
        found: FloatArray = np.sqrt(
            np.maximum(((known**2).sum(axis=0) + unknown + noise) / count, LEAST)
        )
        return found

    @cached_property
    def left_of_errors(self) -> tuple[IntArray, FloatArray]:
        """(e,) columns of tolerance errors, and (e, T', s) what a calibration leaves of them on
        the T' samples of runs left out.
        """
        signal_model, rows = self.signal_model, self.rows_of(self.test or self.train)
        errors = np.flatnonzero(signal_model.built | ~signal_model.shared)
        left = self.calibrated(signal_model.baseline[errors])[:, rows] * signal_model.mask[rows]
        return errors, left

    @cached_property
    def _quiet(self) -> FloatArray:
        """(s, BANDS) variance that noise and forms were expected to have."""
        rows = self.scorer.rows
        built = self.built
        lacking = built.model_level**2 * rows.smooth
        expected = rows.noise + lacking + built.form_level**2 * rows.form
        return rows.by_band(expected, self.noise)

    def rows_of(self, runs: Sequence[int]) -> BoolArray:
        """(T,) samples of some runs."""
        return np.isin(self.signal_model.samples.run, runs)


def make_workspace(
    signal_model: SignalModel,
    effects: Sequence[Effect],
    train: Sequence[int],
    test: Sequence[int],
    settings: DiagnosisSettings,
    tolerances: Tolerances,
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
) -> Workspace:
    """Fit gains, lay out tolerance errors and hypotheses, and find how large the former are."""
    coarse, guess = coarse_noise(signal_model.samples), signal_model.parameters
    signal_model = fit_baseline(signal_model, train, coarse, settings)
    # What test runs show is measured as it is.
    fitted = np.isin(signal_model.samples.run, train)[:, None]
    signal_model = signal_model.leaving_out(jolts(signal_model, settings) & fitted)
    signal_model = replace(signal_model, deviations=tuple(as_built(signal_model, tolerances)))
    catalogue = make_catalogue(signal_model, effects, wanted)
    whole = transformed(signal_model, catalogue)
    rows, withheld = (
        make_rows(signal_model, whole, runs, coarse, settings, guess) for runs in (train, test)
    )
    scorer = Scorer(rows, len(signal_model.parameters.gain), withheld)
    nothing = scorer.nothing
    noise = scorer.rows.by_band(nothing.variance, coarse)
    whitening = Whitening(signal_model.samples, signal_model.mask, noise)
    return Workspace(
        signal_model,
        noise,
        catalogue,
        whitening,
        _products(nothing),
        scorer,
        tuple(train),
        tuple(test),
        tolerances,
        nothing,
    )


def _products(scored: Scored) -> WhitenedProducts:
    """Of all columns and the residuals, on the runs that were fitted, under a fit's variances."""
    rows = scored.scorer.rows
    residuals = rows.residuals + rows.base @ rows.away
    whole = np.column_stack((rows.base, rows.columns, residuals))
    whole /= np.sqrt(scored.variance)[rows.group][:, None]
    return WhitenedProducts(whole.T @ whole, rows.base.shape[1], rows.prior(scored.levels))
