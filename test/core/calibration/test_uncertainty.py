"""Uncertainty of a fit to a walk, against many recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.calibration import synthetic
from core.sensing import shoes
from shoecal_core.calibration.fit import fit_parameters
from shoecal_core.calibration.residuals import Weights, unpack
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.uncertainty import walking_covariance
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
SETTINGS = CalibrationSettings(gain_std=3.0, offset_std_n=100.0, time_offset_std_s=0.0)
"""A weak prior: these few samples shall speak for themselves."""
WEIGHTS = Weights(SETTINGS.force_std_n, SETTINGS.cop_std_m, SETTINGS.correlation_s)
NORMAL_95 = 1.96


def correlated(
    stance: Stance, rng: np.random.Generator, std: float, time_constant: float
) -> Stance:
    """Model errors of the CoP that forget themselves with a time constant [s]."""
    keep = np.exp(-1.0 / synthetic.RATE / time_constant)
    noise = std * rng.standard_normal(stance.cop.shape)
    for index in range(1, len(noise)):
        noise[index] = keep * noise[index - 1] + np.sqrt(1.0 - keep**2) * noise[index]
    return replace(stance, cop=stance.cop + noise)


def fitted(shoe: Shoe, stances: list[Stance]) -> tuple[ChannelParameters, FloatArray]:
    guess = initial_guess(shoe, stances, weight_row=False)
    fit = fit_parameters(shoe, stances, guess, SETTINGS)
    return unpack(fit.vector)[0], walking_covariance(fit, stances, WEIGHTS)


@pytest.mark.parametrize("time_constant", [0.02, 0.4])
def test_intervals_of_gains_hold_in_repeated_recordings(time_constant: float) -> None:
    """Noise correlated in time is not counted as so many samples."""
    shoe, rng = shoes.shoe("nao_shoe"), np.random.default_rng(8)
    truth = synthetic.truth(shoe, rng)
    clean = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:3])
    inside, ratios = [], []
    for _ in range(60):
        stances = [correlated(stance, rng, 0.001, time_constant) for stance in clean]
        found, covariance = fitted(shoe, stances)
        std = np.sqrt(np.diag(covariance))[: len(shoe.names)]
        error = np.abs(found.gain - truth.gain)
        inside.append(error < NORMAL_95 * std)
        ratios.append((error / std) ** 2)
    # Runs of 20 s: their own covariance in time is not known well.
    assert 0.87 <= np.mean(inside) <= 0.99
    assert 0.8 < np.sqrt(np.mean(ratios)) < 1.3


def test_what_is_left_to_the_guess_is_as_uncertain_as_the_prior() -> None:
    """Eight samples of one support tell little: most offsets are as uncertain as before."""
    shoe, rng = shoes.shoe("nao_shoe"), np.random.default_rng(5)
    truth = synthetic.truth(shoe, rng)
    stances = [one.part(slice(0, 8)) for one in synthetic.stances(shoe, truth, rng)[:1]]
    guess = initial_guess(shoe, synthetic.stances(shoe, truth, rng), weight_row=False)
    fit = fit_parameters(shoe, stances, guess, SETTINGS)
    covariance = walking_covariance(fit, stances, WEIGHTS)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9, atol=1e-12)
    count = len(shoe.names)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    assert np.trace(covariance[count:-1, count:-1]) > 0.5 * count * SETTINGS.offset_std_n**2
