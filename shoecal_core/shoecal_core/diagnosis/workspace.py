"""Everything that hypotheses are judged by, made once for a session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.baseline import coarse_noise, fit_baseline
from shoecal_core.diagnosis.hypotheses import Catalogue, make_catalogue
from shoecal_core.diagnosis.rows import make_rows
from shoecal_core.diagnosis.scoring import Scored, Scorer
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.as_built import as_built
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.noise import jolts
from shoecal_core.error_sources.regression import Sums, Whitening, covariance_of, make_sums
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.tolerances import Tolerances

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LEAST = 1e-24
"""Variance of a signal that is not there."""


@dataclass(frozen=True)
class Workspace:
    """A scene under its best parameters, all hypotheses laid out in it, and their sums.

    Attributes:
        scene: with gains and offsets fitted to the training runs.
        noise: (s, BANDS) variance of the coefficients of a robot as built.
        catalogue: of hypotheses.
        whitening: by that noise.
        sums: of the training runs.
        scorer: of the training runs.
        train, test: numbers of the runs.
        tolerances: of the robot's errors as built.
        built: the fit by which the robot's errors as built are as large as they are.
    """

    scene: Scene
    noise: FloatArray
    catalogue: Catalogue
    whitening: Whitening
    sums: Sums
    scorer: Scorer
    train: tuple[int, ...]
    test: tuple[int, ...]
    tolerances: Tolerances
    built: Scored

    def at(self, scored: Scored) -> Workspace:
        """With errors as built as an explanation leaves them."""
        found = replace(self, built=scored)
        # What does not hang on them stays.
        found.__dict__.update(_fitter=self._fitter, left_of_errors=self.left_of_errors)
        return found

    def calibrated(self, values: FloatArray) -> FloatArray:
        """(..., T, s) what a calibration on the training runs leaves of residuals (..., T, s).

        Gains and offsets make up for what they can; errors as built are not known to it.
        """
        kept, fitter = self._fitter
        shape = values.shape
        flat = values.reshape(-1, *shape[-2:])
        rows = self.rows_of(self.train)
        coefficients = self.whitening(flat)[:, rows][:, self.whitening.kept[rows]]
        fitted = coefficients @ fitter.T
        left: FloatArray = flat - np.tensordot(fitted, self.scene.baseline[kept], 1)
        return left.reshape(shape)

    @cached_property
    def _fitter(self) -> tuple[IntArray, FloatArray]:
        """Which of the baseline's columns a calibration has, and (b, R) how they are fitted."""
        scene = self.scene
        kept = np.flatnonzero(scene.shared & ~scene.built)
        rows = self.rows_of(self.train)
        base = self.whitening(scene.baseline[kept])[:, rows][:, self.whitening.kept[rows]]
        return kept, covariance_of(base @ base.T, self.sums.precision[kept]) @ base

    def added(self, scored: Scored | None, part: slice = slice(None)) -> FloatArray:
        """(T, s) what an explanation's columns add: all of them, or some of its components."""
        if scored is None or not scored.parts:
            return np.zeros_like(self.scene.residuals)
        columns = self.catalogue.columns[list(scored.columns[part])]
        added: FloatArray = np.tensordot(scored.sizes[part], columns, 1)
        return added

    def explained(self, scored: Scored | None) -> tuple[FloatArray, FloatArray]:
        """Residuals (T, s) that a calibration leaves beside an explanation, and what that adds."""
        added = self.added(scored)
        return self.calibrated(self.scene.residuals - added), added

    def without(self, scored: Scored, index: int) -> FloatArray:
        """(T, s) residuals that a calibration leaves beside all parts but one."""
        others = self.added(scored) - self.added(scored, scored.own(index))
        return self.calibrated(self.scene.residuals - others)

    @cached_property
    def floor(self) -> FloatArray:
        """(s,) what the robot shows of each signal on runs left out, but for its fault: noise, and
        errors as built as the training runs tell them, where a calibration leaves them.
        """
        rows = self.rows_of(self.test or self.train)
        count = np.maximum(self.scene.mask[rows].sum(axis=0), 1)
        errors, left = self.left_of_errors
        known = np.tensordot(self.built.vector[errors], left, 1)
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
        """Columns of errors as built, and (e, T', s) what a calibration leaves of them there."""
        scene, rows = self.scene, self.rows_of(self.test or self.train)
        errors = np.flatnonzero(scene.built | ~scene.shared)
        left = self.calibrated(scene.baseline[errors])[:, rows] * scene.mask[rows]
        return errors, left

    @cached_property
    def _quiet(self) -> FloatArray:
        """(s, BANDS) variance that noise and forms were expected to have."""
        rows = self.scorer.rows
        built = self.built
        lacking = built.model_level**2 * rows.smooth
        expected = rows.noise + lacking + built.form_level**2 * rows.form
        return rows.by_band(expected, self.noise)

    def rows_of(self, runs: Sequence[int]) -> NDArray[np.bool_]:
        """(T,) samples of some runs."""
        return np.isin(self.scene.samples.run, runs)


def make_workspace(
    scene: Scene,
    effects: Sequence[Effect],
    train: Sequence[int],
    test: Sequence[int],
    settings: DiagnosisSettings,
    tolerances: Tolerances,
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
) -> Workspace:
    """Fit gains, lay out errors as built and hypotheses, and find how large the former are."""
    coarse, guess = coarse_noise(scene.samples), scene.parameters
    scene = fit_baseline(scene, train, coarse, settings)
    # What test runs show is measured as it is.
    fitted = np.isin(scene.samples.run, train)[:, None]
    scene = scene.leaving_out(jolts(scene, settings) & fitted)
    scene = replace(scene, deviations=tuple(as_built(scene, tolerances)))
    catalogue = make_catalogue(scene, effects, wanted)
    rows = make_rows(scene, catalogue, train, coarse, settings, guess)
    scorer = Scorer(rows, len(scene.parameters.gain))
    nothing = scorer.nothing
    noise = scorer.rows.by_band(nothing.variance, coarse)
    whitening = Whitening(scene.samples, scene.mask, noise)
    sums = make_sums(
        whitening,
        train,
        scene.baseline,
        catalogue.columns,
        scene.residuals,
        scorer.rows.prior(nothing.levels),
    )
    return Workspace(
        scene,
        noise,
        catalogue,
        whitening,
        sums,
        scorer,
        tuple(train),
        tuple(test),
        tolerances,
        nothing,
    )
