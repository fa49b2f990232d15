"""Everything that hypotheses are judged by, made once for a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.baseline import coarse_noise, fit_baseline, precision
from shoecal_core.diagnosis.hypotheses import Catalogue, make_catalogue
from shoecal_core.diagnosis.scoring import Scored, Scorer
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.noise import least_noise, noise_of, quiet, with_model_error
from shoecal_core.error_sources.regression import FEW_RUNS, Noise, Sums, Whitening, make_sums, solve
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import COP, OWN_ERRORS

FloatArray = NDArray[np.float64]
NOISE_ROUNDS = 2
RICH = 0.3
"""In the rich model that noise is taken from, every effect has this share of its prior's size."""

OUTLYING = 6.0
"""Noises by which a value must surprise even the rich model to count for nothing: a foot that
touches down, a jolt. A few such would outweigh all others."""


@dataclass(frozen=True)
class Workspace:
    """A scene under its best parameters, all hypotheses laid out in it, and their sums.

    Attributes:
        scene: with gains and offsets fitted to the training runs.
        noise: of the signals.
        quiet: (s,) noise that a robot without a fault has at most.
        catalogue: of hypotheses.
        whitening: by that noise.
        sums: of all runs.
        scorer: of the training runs.
        train, test: numbers of the runs.
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

    def explained(self, scored: Scored | None) -> tuple[FloatArray, FloatArray]:
        """Residuals (T, s) that are left, and what the hypotheses' columns add (T, s).

        Of what every recording may hold only the zero-moment point and what is free count: a
        stance's own error is no explanation.
        """
        scene = self.scene
        solution = self.scorer.nothing if scored is None else scored.solution
        columns = () if scored is None else scored.columns
        base = len(scene.baseline)
        vector = solution.vector[:base].copy()
        vector[self.own_errors] = 0.0
        added = np.tensordot(solution.vector[base:], self.catalogue.columns[list(columns)], 1)
        rest = scene.residuals - np.tensordot(vector, scene.baseline, 1) - added
        return rest, added

    @cached_property
    def powers(self) -> Mapping[str, FloatArray]:
        """(k, k) mean products of all hypotheses' columns, in one axis of the CoP and in GRF."""
        columns, mask = self.catalogue.columns, self.scene.mask[:, 1]
        cop = columns[:, mask, COP].reshape(len(columns), -1)
        grf = columns[:, mask, 0]
        return {"cop": cop @ cop.T / cop.shape[1], "grf": grf @ grf.T / grf.shape[1]}

    @property
    def floor(self) -> FloatArray:
        """(s,) what noise and the stances' own errors leave of each signal, without a fault."""
        return np.hypot(np.minimum(self.noise.std, self.quiet), self.scene.standing_errors)

    @property
    def beyond_all(self) -> FloatArray:
        """(s,) what is left of each signal when every effect may explain a little."""
        return np.hypot(self.noise.std, self.scene.standing_errors)

    @property
    def own_errors(self) -> NDArray[np.int64]:
        """Places of the stances' own errors among the baseline's columns."""
        count = len(self.scene.baseline)
        return np.arange(count - len(OWN_ERRORS) * len(self.scene.slow_segments), count)

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
) -> Workspace:
    """Fit, find the noise, lay out, add up."""
    guess, least, noise = scene.parameters, least_noise(scene), coarse_noise(scene.samples)
    scene = fit_baseline(scene, train, noise, settings)
    catalogue = make_catalogue(scene, effects)
    for _ in range(NOISE_ROUNDS):
        rest = _rest(scene, catalogue, noise, train, settings)
        fitted = scene.mask & np.isin(scene.samples.run, train)[:, None]
        noise = noise_of(scene.samples, fitted, rest)
        noise = Noise(np.maximum(noise.std, least), noise.keep)
        surprise = np.abs(Whitening(scene.samples, scene.mask, noise)(rest))
        scene = scene.leaving_out(fitted & (surprise > OUTLYING))
    noise = with_model_error(scene, noise, settings)
    scene = fit_baseline(scene, train, noise, settings, guess)
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
    return Workspace(
        scene,
        noise,
        quiet(scene, settings),
        catalogue,
        whitening,
        sums,
        Scorer(sums, train),
        tuple(train),
        tuple(test),
    )


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
