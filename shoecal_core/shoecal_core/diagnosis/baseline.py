"""Gains and offsets with nothing added: where every hypothesis starts from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR, CLOSURE, COP, GRF, PARITY, SIGNALS, TILT
from shoecal_core.error_sources.spectrum import BANDS
from shoecal_core.error_sources.whitening import Whitening, make_sums
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.priors import parameter_std
from shoecal_core.shoe.wrench import ChannelParameters, columns_in_left, combined, weight_below

HANGING_LEVERS_M = (0.1, 0.1)
"""Levers by which a swinging foot's forces make moments."""
STEPS = 12
"""After which the iteration ends, settled or not."""
SETTLED = 1e-7
"""Share of the priors; a smaller step ends the iteration."""


def first_parameters(samples: Samples, runs: Sequence[int]) -> ChannelParameters:
    """The paper's initial guess from the samples in which both feet stand.

    Raises:
        ShoecalError: when the samples do not fix it.
    """
    shoe = samples.shoe
    base = weight_below(shoe)
    stances = []
    for segment in np.unique(samples.segment):
        part = (samples.segment == segment) & samples.both
        if not part.any() or int(samples.run[part][0]) not in runs:
            continue
        support = samples.supports[int(segment)]
        stances.append(
            Stance(
                run=int(samples.run[part][0]),
                loaded=(True, True),
                support=support,
                time=samples.time[part],
                readings=samples.readings[part],
                force=samples.force[part],
                cop=samples.cop[part],
                cop_rate=np.zeros_like(samples.cop[part]),
                columns=columns_in_left(shoe, support),
                base=combined(base, support),
            )
        )
    return initial_guess(shoe, stances, weight_row=True).parameters


def precision(
    signal_model: SignalModel, parameters: ChannelParameters, settings: DiagnosisSettings
) -> FloatArray:
    """(p,) prior precision of the baseline's columns."""
    own = parameter_std(
        signal_model.samples.shoe, parameters.gain, signal_model.samples.robot.weight, settings
    )
    others = np.array([one.std for one in signal_model.nuisances])
    return np.asarray(1.0 / np.concatenate((own, others)) ** 2)


def coarse_noise(samples: Samples) -> FloatArray:
    """(s, BANDS) variance before anything is known; dynamics are predicted worse than statics."""
    std = np.ones(len(SIGNALS))
    std[GRF], std[COP] = 0.3, 0.001
    std[AIR], std[CLOSURE], std[PARITY], std[TILT] = (0.1, 0.01, 0.01), 0.001, 0.3, 0.002
    if samples.walks.any():
        weight = samples.robot.weight
        std[GRF], std[COP], std[CLOSURE] = 0.02 * weight, 0.01, 0.003
        std[AIR] = 0.01 * weight * np.array([1.0, *HANGING_LEVERS_M])
    return np.tile(std[:, None] ** 2, BANDS)


def fit_baseline(
    signal_model: SignalModel,
    runs: Sequence[int],
    noise: FloatArray,
    settings: DiagnosisSettings,
) -> SignalModel:
    """Gauss-Newton over gains and offsets on some runs.

    Args:
        signal_model: where the fit starts; priors are about its parameters.
        runs: to fit.
        noise: (s, BANDS) variance of the signals' coefficients.
        settings: of the diagnosis.
    """
    guess = signal_model.parameters
    signal_model = signal_model.with_planes(settings)
    channels = len(guess.gain)
    for _ in range(STEPS):
        # Planes come and go as gains settle, and with them columns.
        prior = precision(signal_model, guess, settings)
        whitening = Whitening(signal_model.samples, signal_model.mask, noise)
        empty = np.zeros((0, *signal_model.residuals.shape))
        sums = make_sums(
            whitening, runs, signal_model.baseline, empty, signal_model.residuals, prior
        )
        # The prior pulls towards the guess, not towards where the fit stands.
        away = np.concatenate(
            (
                signal_model.parameters.gain - guess.gain,
                signal_model.parameters.offset - guess.offset,
                np.zeros(len(prior) - 2 * channels),
            )
        )
        right = sums.products[:-1, -1] + prior * away
        step = Posterior(sums.products[:-1, :-1], prior).solve(right)
        signal_model = signal_model.with_parameters(
            ChannelParameters(
                signal_model.parameters.gain - step[:channels],
                signal_model.parameters.offset - step[channels : 2 * channels],
            )
        )
        signal_model = signal_model.with_planes(settings)
        if np.max(np.abs(step[: 2 * channels]) * np.sqrt(prior[: 2 * channels])) < SETTLED:
            break
    return signal_model
