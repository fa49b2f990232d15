"""All that a diagnosis fits, laid out as cosine coefficients of the training runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.diagnosis.baseline import precision
from shoecal_core.diagnosis.hypotheses import Catalogue
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.noise import colour, form_error, least_noise, white_noise
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR, CLOSURE, COP, GRF, PARITY, TILT
from shoecal_core.error_sources.spectrum import BANDS, BandTransform, frequencies_of, signals_of
from shoecal_core.shoe.wrench import ChannelParameters

FAMILIES = (
    ("link_com", "link_mass"),
    ("joint_offset", "joint_compliance", "backlash"),
    ("joint_friction",),
    ("soft_ground", "support"),
    ("foot_placement", "floor_tilt"),
    ("cell_position", "plates", "crosstalk"),
    ("zero_offset",),
)
"""Sources that are made alike well or badly on one robot; others are as their tolerances say."""
MOST_LEVEL = 2.0
"""Times that their tolerances may count at most: what is worse is a fault."""
MOST_N, MOST_M, MOST_CLOSURE, MOST_RAD = 1.0, 0.004, 0.004, 0.02
"""Beyond what was expected, by which a signal may be off without an explanation."""
SAME = 1e-8
"""Squares by which two columns differ, over their own, that are the same."""
CORNER_HZ = 0.5
"""Below it, readings wander more than white noise does."""
LEAST_SCALE, MOST_SCALE = 0.02, 3.0
"""Between which gains that a fit moves may scale what is measured."""
LEAST_NORM = 1e-24
"""Of a column of zeros, which is divided by."""


@dataclass(frozen=True)
class Rows:
    """Everything that is fitted, as cosine coefficients of the training runs: R of them.

    Attributes:
        base: (R, p). columns: (R, k) of hypotheses.
        residuals: (R,) with gains and offsets as the priors have them.
        away: (p,) how far these are from those that were fitted.
        measured: (R,) CoP and GRF as measured, by the fitted ones; zero for other signals.
        group: (R,) to which of G groups, a signal in a band, each belongs.
        number: (G,) of each group among all there are (`spectrum`).
        noise: (G,) variance by noise.
        form: (G,) the same by the forms of tolerance errors.
        smooth: (G,) by what is not modelled: a smooth term, as large as it usually is.
        most: (G,) variance up to which a group may be more than was expected.
        precision: (p,) of the baseline's priors, at level 1.
        built: (p,) tolerance errors.
        family: (p,) of tolerance errors; -1 for what belongs to none.
        most_level: (F,) of each family.
        same: (k,) column of the baseline that is the same tolerance error; -1 where there is none.
    """

    base: FloatArray
    columns: FloatArray
    residuals: FloatArray
    away: FloatArray
    measured: FloatArray
    group: IntArray
    number: IntArray
    noise: FloatArray
    form: FloatArray
    smooth: FloatArray
    most: FloatArray
    precision: FloatArray
    built: BoolArray
    family: IntArray
    most_level: FloatArray
    same: IntArray

    @property
    def signal(self) -> IntArray:
        """(G,) of each group."""
        return signals_of(self.number)

    def by_band(self, values: FloatArray, usual: FloatArray) -> FloatArray:
        """(s, BANDS) of values by group (G,); as usual where no group is."""
        found = usual.copy()
        found.ravel()[self.number] = values
        return found

    @cached_property
    def count(self) -> FloatArray:
        """(G,) rows of each group."""
        return np.bincount(self.group, minlength=len(self.number)).astype(np.float64)

    def squares(self, values: FloatArray) -> FloatArray:
        """(G,) sums of squares of values (R,)."""
        return np.bincount(self.group, values**2, minlength=len(self.number)).astype(np.float64)

    def prior(self, levels: FloatArray) -> FloatArray:
        """(p,) precision where families are at these levels (F,)."""
        return at_levels(self.precision, self.family, levels)

    @cached_property
    def _gains(self) -> tuple[tuple[IntArray, FloatArray, FloatArray], ...]:
        """Of each signal that is measured: its groups, values and columns."""
        found = []
        for signal in np.unique(self.signal[self.group[self.measured != 0.0]]):
            here = (self.signal[self.group] == signal) & (self.measured != 0.0)
            groups = np.flatnonzero(self.signal == signal)
            found.append((groups, self.measured[here], self.base[here]))
        return tuple(found)

    def scales(self, moved: FloatArray) -> FloatArray:
        """(G,) of what is measured, under gains and offsets (2 n,) that a fit moves."""
        found = np.ones(len(self.number))
        for groups, measured, base in self._gains:
            now = measured - base[:, : len(moved)] @ moved
            scale = float(measured @ now) / float(measured @ measured)
            found[groups] = np.clip(scale, LEAST_SCALE, MOST_SCALE)
        return found


def at_levels(precision: FloatArray, family: IntArray, levels: FloatArray) -> FloatArray:
    """(k,) precision of priors that have another (k,) at level 1.

    Args:
        precision: that one.
        family: (k,) of tolerance errors; -1 for what belongs to none.
        levels: (F,) of the families.
    """
    level = np.where(family < 0, 1.0, levels[np.maximum(family, 0)])
    found: FloatArray = precision * level**-2.0
    return found


@dataclass(frozen=True)
class Coefficients:
    """All that is laid out, transformed once for all runs: K coefficients that count.

    Attributes:
        run: (K,) of each. band: (K,) its signal and band (`spectrum`).
        base: (K, p). columns: (K, k). residuals, measured: (K,); see `Rows`.
    """

    run: IntArray
    band: IntArray
    base: FloatArray
    columns: FloatArray
    residuals: FloatArray
    measured: FloatArray


def transformed(signal_model: SignalModel, catalogue: Catalogue) -> Coefficients:
    """Coefficients of baseline, hypotheses, residuals, and of what is measured."""
    samples = signal_model.samples
    spectrum = BandTransform(samples, signal_model.mask)
    kept = spectrum.kept

    def coefficients(values: FloatArray) -> FloatArray:
        return np.ascontiguousarray(spectrum(values)[..., kept].T)

    measured = np.zeros_like(signal_model.residuals)
    measured[:, GRF], measured[:, COP] = signal_model.wrench[:, :1], signal_model.cop
    return Coefficients(
        run=np.broadcast_to(samples.run[:, None], kept.shape)[kept],
        band=spectrum.group[kept],
        base=coefficients(signal_model.baseline),
        columns=coefficients(catalogue.columns),
        residuals=coefficients(signal_model.residuals),
        measured=coefficients(np.where(signal_model.mask, measured, 0.0)),
    )


def make_rows(
    signal_model: SignalModel,
    whole: Coefficients,
    runs: Sequence[int],
    coarse: FloatArray,
    settings: DiagnosisSettings,
    guess: ChannelParameters,
) -> Rows:
    """Lay out some runs.

    Args:
        signal_model: with gains and offsets fitted, and tolerance errors.
        whole: its coefficients.
        runs: numbers.
        coarse: (s, BANDS) variance before anything is known.
        settings: of the diagnosis.
        guess: gains and offsets that priors are about.
    """
    samples = signal_model.samples
    here = np.isin(whole.run, runs)
    present, group = np.unique(whole.band[here], return_inverse=True)
    signal, frequency = signals_of(present), frequencies_of(present)
    base, columns = whole.base[here], whole.columns[here]
    prior, away = precision(signal_model, guess, settings), _away(signal_model, guess)
    free = _unabsorbed(base, prior, signal_model, 1.0 / np.sqrt(coarse.ravel()[present])[group])
    count = np.bincount(group)
    form = np.bincount(group, ((free * _form_stds(signal_model)) ** 2).sum(axis=1)) / count
    measured = whole.measured[here]
    # The mean of a stance does not contain how far the CoP moves.
    measured[np.isin(signal, np.r_[COP])[group] & (present[group] % BANDS == 0)] = 0.0
    white = np.maximum(white_noise(signal_model), least_noise(signal_model))[signal] ** 2
    smooth = form_error(signal_model, settings)[signal] ** 2 * colour(samples, frequency, settings)
    return Rows(
        base=base,
        columns=columns,
        residuals=whole.residuals[here] - base @ away,
        away=away,
        measured=measured,
        group=group,
        number=present,
        noise=white * _flicker(signal, frequency),
        form=form,
        smooth=smooth,
        most=_most(signal_model)[signal] ** 2,
        precision=prior,
        built=signal_model.built,
        family=_families(signal_model),
        most_level=np.full(len(FAMILIES), MOST_LEVEL),
        same=_same(base, columns, signal_model),
    )


def _families(signal_model: SignalModel) -> IntArray:
    """(p,) to which of FAMILIES each column of the baseline belongs; -1 for those of none."""
    of = {effect: at for at, effects in enumerate(FAMILIES) for effect in effects}
    found = np.full(len(signal_model.baseline), -1)
    found[signal_model.built] = [of.get(one.effect, -1) for one in signal_model.deviations]
    return found


def _same(base: FloatArray, columns: FloatArray, signal_model: SignalModel) -> IntArray:
    """(k,) tolerance error that each of the hypotheses' columns (R, k) also is; -1 for none."""
    built = np.flatnonzero(signal_model.built)
    found = np.full(columns.shape[1], -1)
    if not len(built):
        return found
    own = np.maximum(np.linalg.norm(columns, axis=0), LEAST_NORM)
    away = (base[:, built] ** 2).sum(axis=0)[:, None] + own**2
    away = away - 2.0 * base[:, built].T @ columns
    nearest = np.argmin(away, axis=0)
    here = away[nearest, np.arange(len(found))] < SAME * own**2
    found[here] = built[nearest[here]]
    return found


def _away(signal_model: SignalModel, guess: ChannelParameters) -> FloatArray:
    """(p,) how far the fitted gains and offsets are from what priors are about."""
    found = np.zeros(len(signal_model.baseline))
    fitted = signal_model.parameters
    moved = np.concatenate((fitted.gain - guess.gain, fitted.offset - guess.offset))
    found[: len(moved)] = moved
    return found


def _unabsorbed(
    base: FloatArray, prior: FloatArray, signal_model: SignalModel, weight: FloatArray
) -> FloatArray:
    """(R, d) what all else in the baseline leaves of tolerance errors."""
    whole = base * weight[:, None]
    kept = ~signal_model.built
    posterior = Posterior(whole[:, kept].T @ whole[:, kept], prior[kept])
    fitted = posterior.solve(whole[:, kept].T @ whole[:, signal_model.built])
    left: FloatArray = base[:, signal_model.built] - base[:, kept] @ fitted
    return left


def _form_stds(signal_model: SignalModel) -> FloatArray:
    """(d,) of tolerance errors: what they add in another form than the library has them in."""
    return np.array([one.form * one.std for one in signal_model.deviations])


def _flicker(signal: IntArray, frequency: FloatArray) -> FloatArray:
    """(G,) times white noise that signals of readings have."""
    read = np.isin(signal, np.r_[GRF, COP, AIR, PARITY])
    return np.where(read, 1.0 + CORNER_HZ / frequency, 1.0)


def _most(signal_model: SignalModel) -> FloatArray:
    """(s,) by which a signal may be off beyond what was expected."""
    found = np.zeros(signal_model.residuals.shape[1])
    found[GRF], found[COP], found[TILT] = MOST_N, MOST_M, MOST_RAD
    found[AIR], found[PARITY] = MOST_N * np.array([1.0, 0.1, 0.1]), 1.5 * MOST_N
    found[CLOSURE] = (*(3 * (MOST_CLOSURE,)), *(3 * (MOST_RAD,)))
    return found
