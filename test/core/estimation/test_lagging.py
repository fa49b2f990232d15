"""A cell that settles slowly is found, whichever it is; others are never accused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, lfiltic

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.estimation.fit import fit_parameters, prior_of
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.lagging import Lag, check_lags, lags
from shoecal_core.estimation.residuals import ResidualWeights
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SETTINGS = CalibrationSettings()
NOISE_N = 0.05


def settling(stance: Stance, channel: int, seconds: float) -> Stance:
    """The same with one channel behind a filter of first order."""
    pole = np.exp(-(stance.time[1] - stance.time[0]) / seconds)
    readings = stance.readings.copy()
    start = lfiltic([1.0 - pole], [1.0, -pole], readings[:1, channel])
    readings[:, channel] = lfilter([1.0 - pole], [1.0, -pole], readings[:, channel], zi=start)[0]
    return replace(stance, readings=readings)


def found_lags(shoe: Shoe, runs: Sequence[Stance]) -> tuple[Lag, ...]:
    guess = initial_guess(shoe, runs, weight_row=False)
    fit = fit_parameters(shoe, runs, guess, SETTINGS)
    return lags(
        fit.vector, prior_of(shoe, guess, runs, SETTINGS), runs, ResidualWeights.of(SETTINGS)
    )


def recorded(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> list[Stance]:
    clean = synthetic.stances(shoe, truth, rng, noise=NOISE_N)
    return [synthetic.with_model_noise(run, rng, 0.3, 2e-3) for run in clean]


def test_cells_that_follow_at_once_are_left_alone(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    found = found_lags(shoe, recorded(shoe, truth, rng))
    assert [lag.channel for lag in found] == list(range(len(shoe.names)))
    assert not any(lag.found for lag in found)
    assert all(abs(lag.seconds) < max(0.05, 4.0 * lag.std) for lag in found)
    assert check_lags(shoe, found) == []


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 7), st.floats(0.3, 1.5))
def test_the_one_that_settles_slowly_is_named(channel: int, seconds: float) -> None:
    shoe, rng = shoes.shoe("nao_shoe"), np.random.default_rng(20)
    runs = recorded(shoe, synthetic.truth(shoe, rng), rng)
    found = found_lags(shoe, [settling(run, channel, seconds) for run in runs])
    (finding,) = check_lags(shoe, found)
    assert (finding.verdict, finding.fault) == ("FAIL", Fault.SLOW)
    assert finding.reason.startswith(f"{shoe.names[channel]} follows its load late, by ")
    assert found[channel].seconds == pytest.approx(seconds, rel=0.1)


def test_few_samples_tell_nothing(rng: np.random.Generator) -> None:
    shoe = shoes.shoe("nao_shoe")
    runs = recorded(shoe, synthetic.truth(shoe, rng), rng)
    guess = initial_guess(shoe, runs, weight_row=False)
    prior, weights = prior_of(shoe, guess, runs, SETTINGS), ResidualWeights.of(SETTINGS)
    short = [run.part(slice(0, 5)) for run in runs]
    assert lags(prior.mean, prior, [*runs, *short], weights) == lags(
        prior.mean, prior, runs, weights
    )
    assert not any(lag.found for lag in lags(prior.mean, prior, short, weights))
