"""Everything that hypotheses are judged by, made once for a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.baseline import coarse_noise, fit_baseline, precision
from shoecal_core.diagnosis.hypotheses import Catalogue, make_catalogue
from shoecal_core.diagnosis.scoring import Scored, Scorer
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.as_built import as_built
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.noise import least_noise, noise_of, quiet, with_model_error
from shoecal_core.error_sources.regression import FEW_RUNS, Noise, Sums, Whitening, make_sums, solve
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import COP
from shoecal_core.error_sources.tolerances import Tolerances

FloatArray = NDArray[np.float64]
NOISE_ROUNDS = 2
RICH = 0.3
"""In the rich model that noise is taken from, every effect has this share of its prior's size."""

LEVELS = (0.1, 0.3, 1.0)
"""Factors on all tolerances."""
OUTLYING = 6.0
"""Noises by which a value must surprise even the rich model to count for nothing: a foot that
touches down, a jolt. A few such would outweigh all others."""


@dataclass(frozen=True)
class Workspace:
    """A scene under its best parameters, all hypotheses laid out in it, and their sums.

    Attributes:
        scene: with gains and offsets fitted to the training runs.
        noise: of the signals.
        quiet: (L, s) noise that a robot without a fault has at most, by level of the tolerances.
        catalogue: of hypotheses.
        whitening: by that noise.
        sums: of all runs.
        scorer: of the training runs.
        train, test: numbers of the runs.
        level: of the tolerances that the floor is of.
        tolerances: how far a robot may be off its files.
    """

    scene: Scene
    noise: Noise
    quiet: FloatArray
    catalogue: Catalogue
    whitening: Whitening
    sums: Sums
    scorer: Scorer
    train: tuple[int, ...]
    test: tuple[int, ...]
    level: int
    tolerances: Tolerances

    def at(self, level: int) -> Workspace:
        """With the floor of a robot of another level of the tolerances."""
        return replace(self, level=level)

    def explained(self, scored: Scored | None) -> tuple[FloatArray, FloatArray]:
        """Residuals (T, s) that are left, and what the hypotheses' columns add (T, s).

        Of what every recording may hold only what all runs share counts: a run's or a stance's own
        error is no explanation.
        """
        scene = self.scene
        solution = self.scorer.nothing if scored is None else scored.solution
        base = len(scene.baseline)
        vector = np.where(scene.shared, solution.vector[:base], 0.0)
        added = self._added(scored)
        rest = scene.residuals - np.tensordot(vector, scene.baseline, 1) - added
        return rest, added

    def _added(self, scored: Scored | None, part: slice = slice(None)) -> FloatArray:
        """(T, s) what hypotheses' columns add, of all parts or of some components."""
        if scored is None:
            return np.zeros_like(self.scene.residuals)
        own = scored.solution.vector[len(self.scene.baseline) :][part]
        columns = self.catalogue.columns[list(scored.columns[part])]
        added: FloatArray = np.tensordot(own, columns, 1)
        return added

    def absorbed(self, scored: Scored, index: int | None = None) -> tuple[FloatArray, FloatArray]:
        """What parts of an explanation add to the signals (T, s), and what of it a calibration
        without them would absorb into gains and offsets (T, s).

        Args:
            index: of one part; None: all of them.
        """
        part = slice(None) if index is None else scored.own(index)
        scene, scorer = self.scene, self.scorer
        base = len(scene.baseline)
        columns = base + np.array(scored.columns[part], dtype=np.int64)
        sizes = scored.solution.vector[base:][part]
        kept = np.flatnonzero(scene.shared & ~scene.built)
        normal = scorer.products[np.ix_(kept, kept)].copy()
        normal[np.diag_indices_from(normal)] += self.sums.precision[kept]
        right = scorer.products[np.ix_(kept, columns)] @ sizes
        scale = 1.0 / np.sqrt(np.diag(normal))
        fitted = scale * np.linalg.solve(normal * np.outer(scale, scale), scale * right)
        return self._added(scored, part), np.tensordot(fitted, scene.baseline[kept], 1)

    def without(self, scored: Scored | None, index: int | None = None) -> FloatArray:
        """(T, s) residuals where an explanation is left out, all else as it was found.

        Of nothing: those of the fit with nothing added. A part that is left out is not made up for
        by as-built deviations, only by gains and offsets.
        """
        rest, _ = self.explained(scored)
        if scored is None:
            return rest
        added, absorbed = self.absorbed(scored, index)
        return rest + added - absorbed

    @cached_property
    def powers(self) -> Mapping[str, FloatArray]:
        """(k, k) mean products of all hypotheses' columns, in one axis of the CoP and in GRF."""
        columns, mask = self.catalogue.columns, self.scene.mask[:, 1]
        cop = columns[:, mask, COP].reshape(len(columns), -1)
        grf = columns[:, mask, 0]
        return {"cop": cop @ cop.T / cop.shape[1], "grf": grf @ grf.T / grf.shape[1]}

    @cached_property
    def floor(self) -> FloatArray:
        """(s,) what a robot without a fault shows of each signal where it was not fitted: noise,
        errors of single runs and stances, and what the fit does not know.
        """
        return np.hypot(np.minimum(self.noise.std, self.quiet[self.level]), self._unfitted)

    @cached_property
    def beyond_all(self) -> FloatArray:
        """(s,) the same with what is left when every effect may explain a little."""
        return np.hypot(self.noise.std, self._unfitted)

    @cached_property
    def _unfitted(self) -> FloatArray:
        """(s,) root mean square of what the baseline may add to runs that were not fitted."""
        scene, rows = self.scene, self.rows_of(self.test or self.train)
        level = self.scorer.levels[self.level]
        covariance = solve(self.scorer.products, level, (), np.zeros(0)).covariance
        single = ~scene.shared
        covariance[single], covariance[:, single] = 0.0, 0.0
        covariance[single, single] = 1.0 / level.precision[single]
        baseline = scene.baseline[:, rows]
        variance = np.einsum("ptx,ptx->tx", baseline, np.tensordot(covariance, baseline, 1))
        there = scene.mask[rows]
        count = np.maximum(there.sum(axis=0), 1)
        spread: FloatArray = np.sqrt(np.where(there, variance, 0.0).sum(axis=0) / count)
        return spread

    def rows_of(self, runs: Sequence[int]) -> NDArray[np.bool_]:
        """(T,) samples of some runs."""
        return np.isin(self.scene.samples.run, runs)


def make_workspace(
    scene: Scene,
    effects: Sequence[Effect],
    train: Sequence[int],
    test: Sequence[int],
    settings: DiagnosisSettings,
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
    tolerances: Tolerances | None = None,
) -> Workspace:
    """Fit, find the noise, lay out, add up."""
    tolerances = Tolerances() if tolerances is None else tolerances
    guess, least, noise = scene.parameters, least_noise(scene), coarse_noise(scene.samples)
    scene = fit_baseline(with_deviations(scene, tolerances), train, noise, settings)
    catalogue = make_catalogue(scene, effects)
    for _ in range(NOISE_ROUNDS):
        rest = _rest(scene, catalogue, noise, train, settings)
        fitted = scene.mask & np.isin(scene.samples.run, train)[:, None]
        noise = noise_of(scene.samples, fitted, rest)
        noise = Noise(np.maximum(noise.std, least), noise.keep)
        scene = scene.leaving_out(fitted & (np.abs(rest) > OUTLYING * noise.std))
    noise = with_model_error(scene, noise, settings)
    scene = fit_baseline(with_deviations(scene, tolerances), train, noise, settings, guess)
    scene = with_deviations(scene, tolerances)
    catalogue = make_catalogue(scene, effects, wanted)
    whitening = Whitening(scene.samples, scene.mask, noise)
    sums = make_sums(
        whitening,
        [*train, *test],
        scene.baseline,
        catalogue.columns,
        scene.residuals,
        scene.mask,
        precision(scene, scene.parameters, settings),
        cut=len(train) < FEW_RUNS,
    )
    levels = [
        replace(sums, precision=at_level(sums.precision, scene, level))
        for level in range(len(LEVELS))
    ]
    scorer = Scorer(levels, train)
    return Workspace(
        scene,
        noise,
        np.array([quiet(scene, settings, level) for level in LEVELS]),
        catalogue,
        whitening,
        sums,
        scorer,
        tuple(train),
        tuple(test),
        scorer.level,
        tolerances,
    )


def with_deviations(scene: Scene, tolerances: Tolerances) -> Scene:
    """With its as-built deviations, linear about where it is."""
    return replace(scene, deviations=tuple(as_built(scene, tolerances)))


def at_level(precision: FloatArray, scene: Scene, level: int) -> FloatArray:
    """(p,) precision of the baseline's priors where the tolerances count at one of LEVELS."""
    found: FloatArray = np.where(scene.built, precision / LEVELS[level] ** 2, precision)
    return found


def _rest(
    scene: Scene,
    catalogue: Catalogue,
    noise: Noise,
    train: Sequence[int],
    settings: DiagnosisSettings,
) -> FloatArray:
    """(T, s) that is left when every effect may explain a little."""
    whitening = Whitening(scene.samples, scene.mask, noise)
    prior = precision(scene, scene.parameters, settings)
    sums = make_sums(
        whitening, train, scene.baseline, catalogue.columns, scene.residuals, scene.mask, prior
    )
    products, _ = sums.of(train)
    # What was taken from the signals themselves would explain their noise too.
    forms = [form for hypothesis in catalogue.hypotheses for form in hypothesis.foreseen]
    chosen = [column for form in forms for column in form.columns]
    std = np.concatenate([np.zeros(0), *(form.std for form in forms)])
    vector = solve(products, sums, chosen, RICH * std).vector
    base = len(scene.baseline)
    rest: FloatArray = (
        scene.residuals
        - np.tensordot(vector[:base], scene.baseline, 1)
        - np.tensordot(vector[base:], catalogue.columns[chosen], 1)
    )
    return rest
