"""Everything that hypotheses are judged by, made once for a session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.baseline import coarse_noise, fit_baseline, precision
from shoecal_core.diagnosis.hypotheses import Catalogue, make_catalogue
from shoecal_core.diagnosis.scoring import Rows, Scored, Scorer
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.as_built import as_built
from shoecal_core.error_sources.base import Effect, Place
from shoecal_core.error_sources.noise import colour, form_error, jolts, least_noise, white_noise
from shoecal_core.error_sources.regression import Sums, Whitening, make_sums
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import AIR, CLOSURE, COP, GRF, PARITY, TILT
from shoecal_core.error_sources.spectrum import BANDS, frequencies_of, signals_of
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FAMILIES = (
    ("link_com", "link_mass"),
    ("joint_offset", "joint_compliance", "backlash"),
    ("soft_ground", "support"),
    ("foot_placement", "floor_tilt"),
    ("cell_position", "plates", "crosstalk"),
    ("zero_offset",),
)
"""Sources that are made alike well or badly on one robot."""
MOST_LEVEL = 2.0
"""Times that their tolerances may count at most: what is worse is a fault."""
MOST_N, MOST_M, MOST_CLOSURE, MOST_RAD = 1.0, 0.004, 0.004, 0.02
"""Beyond what was expected, by which a signal may be off without an explanation."""
SAME = 1e-8
"""Squares by which two columns differ, over their own, that are the same."""
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
    built: Scored

    def at(self, scored: Scored) -> Workspace:
        """With errors as built as an explanation leaves them."""
        return replace(self, built=scored)

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
        normal = base @ base.T + np.diag(self.sums.precision[kept])
        scale = 1.0 / np.sqrt(np.diag(normal))
        inverse = np.linalg.inv(normal * np.outer(scale, scale) + 1e-12 * np.eye(len(kept)))
        return kept, (inverse * np.outer(scale, scale)) @ base

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
        scene, rows = self.scene, self.rows_of(self.test or self.train)
        there = scene.mask[rows]
        count = np.maximum(there.sum(axis=0), 1)
        errors = np.flatnonzero(scene.built | ~scene.shared)
        solution = self.built.solution
        left = self.calibrated(scene.baseline[errors])[:, rows]
        left *= there
        known = np.tensordot(solution.vector[errors], left, 1)
        spread = solution.covariance[np.ix_(errors, errors)]
        unknown = np.array([np.sum(one * (spread @ one)) for one in np.moveaxis(left, 2, 0)])
        kept, group = self.whitening.kept[rows], self.whitening.spectrum.group[rows]
        noise = np.where(kept, self._quiet.ravel()[group], 0.0).sum(axis=0)
        found: FloatArray = np.sqrt(
            np.maximum(((known**2).sum(axis=0) + unknown + noise) / count, LEAST)
        )
        return found

    @cached_property
    def _quiet(self) -> FloatArray:
        """(s, BANDS) variance that noise and forms were expected to have."""
        rows = self.scorer.rows
        expected = rows.noise + self.built.form_level**2 * rows.form
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
    wanted: Callable[[str, Place], bool] = lambda _effect, _place: True,
) -> Workspace:
    """Fit gains, lay out errors as built and hypotheses, and find how large the former are."""
    coarse, guess = coarse_noise(scene.samples), scene.parameters
    scene = fit_baseline(scene, train, coarse, settings)
    # What test runs show is measured as it is.
    fitted = np.isin(scene.samples.run, train)[:, None]
    scene = scene.leaving_out(jolts(scene, settings) & fitted)
    scene = with_deviations(scene, Tolerances())
    catalogue = make_catalogue(scene, effects, wanted)
    rows = _rows(scene, catalogue, train, coarse, settings, guess)
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
        scene, noise, catalogue, whitening, sums, scorer, tuple(train), tuple(test), nothing
    )


def with_deviations(scene: Scene, tolerances: Tolerances) -> Scene:
    """With its as-built deviations, linear about where it is."""
    return replace(scene, deviations=tuple(as_built(scene, tolerances)))


def families(scene: Scene) -> IntArray:
    """(p,) to which of FAMILIES each column of the baseline belongs; -1 for what is no error."""
    of = {effect: at for at, effects in enumerate(FAMILIES) for effect in effects}
    found = np.full(len(scene.baseline), -1)
    found[scene.built] = [of[one.effect] for one in scene.deviations]
    return found


def _rows(
    scene: Scene,
    catalogue: Catalogue,
    train: Sequence[int],
    coarse: FloatArray,
    settings: DiagnosisSettings,
    guess: ChannelParameters,
) -> Rows:
    samples = scene.samples
    flat = Whitening(samples, scene.mask, np.ones_like(coarse))
    part = np.isin(samples.run, train)
    kept = flat.kept & part[:, None]

    def coefficients(values: FloatArray) -> FloatArray:
        return np.ascontiguousarray(flat(values)[..., kept].T)

    present, group = np.unique(flat.spectrum.group[kept], return_inverse=True)
    signal, frequency = signals_of(present), frequencies_of(present)
    base = coefficients(scene.baseline)
    prior, away = precision(scene, guess, settings), _away(scene, guess)
    free = _unabsorbed(base, prior, scene, 1.0 / np.sqrt(coarse.ravel()[present])[group])
    count = np.bincount(group)
    form = np.bincount(group, ((free * _form_stds(scene)) ** 2).sum(axis=1)) / count
    measured = np.zeros_like(scene.residuals)
    measured[:, GRF], measured[:, COP] = scene.wrench[:, :1], scene.cop
    taken = coefficients(np.where(scene.mask, measured, 0.0))
    # The mean of a stance does not tell how far the CoP moves.
    taken[np.isin(signal, np.r_[COP])[group] & (present[group] % BANDS == 0)] = 0.0
    white = np.maximum(white_noise(scene), least_noise(scene))[signal] ** 2
    smooth = form_error(scene, settings)[signal] ** 2 * colour(samples, frequency, settings)
    columns = coefficients(catalogue.columns)
    return Rows(
        base=base,
        columns=columns,
        residuals=coefficients(scene.residuals) - base @ away,
        away=away,
        measured=taken,
        group=group,
        number=present,
        noise=white * _flicker(signal, frequency) + smooth,
        form=form,
        smooth=smooth,
        most=_most(scene)[signal] ** 2,
        precision=prior,
        family=families(scene),
        most_level=np.full(len(FAMILIES), MOST_LEVEL),
        same=_same(base, columns, scene),
    )


def _same(base: FloatArray, columns: FloatArray, scene: Scene) -> IntArray:
    """(k,) error as built that each of the hypotheses' columns (R, k) also is; -1 for none."""
    built = np.flatnonzero(scene.built)
    found = np.full(columns.shape[1], -1)
    if not len(built):
        return found
    own = np.maximum(np.linalg.norm(columns, axis=0), LEAST)
    away = (base[:, built] ** 2).sum(axis=0)[:, None] + own**2
    away = away - 2.0 * base[:, built].T @ columns
    nearest = np.argmin(away, axis=0)
    here = away[nearest, np.arange(len(found))] < SAME * own**2
    found[here] = built[nearest[here]]
    return found


def _away(scene: Scene, guess: ChannelParameters) -> FloatArray:
    """(p,) how far the fitted gains and offsets are from what priors are about."""
    found = np.zeros(len(scene.baseline))
    fitted = scene.parameters
    moved = np.concatenate((fitted.gain - guess.gain, fitted.offset - guess.offset))
    found[: len(moved)] = moved
    return found


def _unabsorbed(
    base: FloatArray, prior: FloatArray, scene: Scene, weight: FloatArray
) -> FloatArray:
    """(R, d) what all else in the baseline leaves of errors as built."""
    whole = base * weight[:, None]
    kept = ~scene.built
    normal = whole[:, kept].T @ whole[:, kept] + np.diag(prior[kept])
    scale = 1.0 / np.sqrt(np.diag(normal))
    right = scale[:, None] * (whole[:, kept].T @ whole[:, scene.built])
    system = normal * np.outer(scale, scale) + 1e-12 * np.eye(len(scale))
    fitted = scale[:, None] * np.linalg.solve(system, right)
    left: FloatArray = base[:, scene.built] - base[:, kept] @ fitted
    return left


def _form_stds(scene: Scene) -> FloatArray:
    """(d,) of errors as built: what they add in another form than the library has them in."""
    return np.array([one.form * one.std for one in scene.deviations])


CORNER_HZ = 0.5
"""Below it, readings wander more than white noise does."""


def _flicker(signal: IntArray, frequency: FloatArray) -> FloatArray:
    """(G,) times white noise that signals of readings have."""
    read = np.isin(signal, np.r_[GRF, COP, AIR, PARITY])
    return np.where(read, 1.0 + CORNER_HZ / frequency, 1.0)


def _most(scene: Scene) -> FloatArray:
    """(s,) by which a signal may be off beyond what was expected."""
    found = np.zeros(scene.residuals.shape[1])
    found[GRF], found[COP], found[TILT] = MOST_N, MOST_M, MOST_RAD
    found[AIR], found[PARITY] = MOST_N * np.array([1.0, 0.1, 0.1]), 1.5 * MOST_N
    found[CLOSURE] = (*(3 * (MOST_CLOSURE,)), *(3 * (MOST_RAD,)))
    return found
