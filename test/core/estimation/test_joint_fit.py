"""The joint fit of robots whose errors are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.estimation.drawn import SETTINGS, TOLERANCES, Drawn, drawn
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.joint_fit import SETTLED, fit_jointly
from shoecal_core.samples.samples import Samples
from shoecal_core.shoe.wrench import cop, foot_wrenches

NORMAL_95 = 1.96
SEEDS = (2, 3, 4, 5)


@pytest.fixture(scope="module")
def several(known: Drawn) -> tuple[Drawn, ...]:
    """Robots with all as-built errors."""
    return known, *(drawn(seed) for seed in SEEDS)


def standardised(found: Drawn) -> FloatArray:
    """(2n + 1 + k,) errors in their stated standard deviations."""
    return np.asarray(found.errors / np.sqrt(np.diag(found.fit.covariance)))


def test_nothing_wrong_is_found_where_nothing_is() -> None:
    """Gains to a thousandth, from a guess that is off by 15 %, and no deviation."""
    found = drawn(6, share=0.0, noise=0.0)
    count = len(found.parameters.gain)
    np.testing.assert_allclose(found.fit.parameters.gain, found.parameters.gain, rtol=2e-3)
    small = [abs(one.value) < 0.2 * one.deviation.std for one in found.fit.deviations]
    assert all(small)
    assert np.abs(standardised(found)[count:]).max() < 0.5


def test_truth_is_within_the_stated_intervals(several: tuple[Drawn, ...]) -> None:
    """Of gains, offsets, time offset and every deviation."""
    ratios = np.concatenate([standardised(one) for one in several])
    assert 0.90 <= np.mean(np.abs(ratios) < NORMAL_95) <= 0.99
    assert 0.8 < np.sqrt(np.mean(ratios**2)) < 1.2
    count = len(several[0].parameters.gain)
    gains = np.concatenate([standardised(one)[:count] for one in several])
    assert np.mean(np.abs(gains) < NORMAL_95) > 0.8


def test_gains_and_deviations_that_the_data_show_are_found(several: tuple[Drawn, ...]) -> None:
    for one in several:
        count = len(one.parameters.gain)
        assert np.abs(one.errors[:count] / one.parameters.gain).max() < 0.03
    # What the recording shows well comes out as it is, whatever its size.
    ends = [
        (fitted.value, one.values[fitted.deviation.key], fitted.deviation.std)
        for one in several
        for fitted in one.fit.deviations
        if fitted.std < 0.4 * fitted.deviation.std
    ]
    found, true, std = np.array(ends).T
    assert len(found) > 20
    assert np.corrcoef(found / std, true / std)[0, 1] > 0.9


def test_it_certifies_itself(known: Drawn) -> None:
    fit = known.fit
    assert fit.last_step < SETTLED
    assert fit.cost < 0.01 * fit.initial_cost
    scaled = fit.covariance / np.outer(fit.prior_std, fit.prior_std)
    np.testing.assert_allclose(scaled, scaled.T, atol=1e-6)
    values = np.linalg.eigvalsh(scaled)
    assert values.min() > 0.0
    assert values.max() < 1.0 + 1e-6
    assert np.linalg.eigvalsh(fit.information).min() > -1e-6 * np.abs(fit.information).max()


def test_each_foot_measures_with_the_shoe_that_was_found(known: Drawn) -> None:
    """The CoP of a foot by the fitted columns is nearer to the truth than by the file's."""
    fit, samples = known.fit, known.fit.signal_model.samples
    both = samples.both
    truth = samples.shoe.columns.copy()
    for one in fit.deviations:
        if one.deviation.shoe_column is not None:
            truth += known.values[one.deviation.key] * one.deviation.shoe_column
    exact = foot_wrenches(
        samples.shoe.with_columns(truth), known.parameters.outputs(samples.readings[both])
    )
    off = []
    for shoe in (fit.shoe, samples.shoe):
        found = foot_wrenches(shoe, fit.parameters.outputs(samples.readings[both]))
        places = [cop(found[:, foot], 1.0) - cop(exact[:, foot], 1.0) for foot in (0, 1)]
        off.append(np.sqrt(np.mean(np.square(places))))
    assert off[0] < off[1]
    assert off[0] < 1.5e-3


@pytest.mark.parametrize(("noise", "most"), [(0.5, 0.01), (1.0, 0.02)])
def test_noise_of_readings_does_not_bias_gains(noise: float, most: float) -> None:
    """Readings come at 100 Hz, of which a sample averages 25."""
    ratios = []
    for seed in (11, 12, 13):
        found = drawn(seed, share=0.0, noise=noise / np.sqrt(25.0), count=80)
        ratios.append(found.fit.parameters.gain / found.parameters.gain)
    assert abs(np.mean(ratios) - 1.0) < most


def test_runs_that_are_not_fitted_have_no_part(known: Drawn) -> None:
    """Their readings may be anything, as long as they are numbers."""
    samples = known.fit.signal_model.samples
    last = samples.runs[-3]
    train = [run for run in samples.runs if run != last]
    wild = samples.readings.copy()
    wild[samples.run == last] += 0.01 * np.abs(wild).mean()
    guess = known.parameters
    first, second = (
        fit_jointly(one, train, guess, SETTINGS, TOLERANCES, 0.02).parameters
        for one in (samples, replace(samples, readings=wild))
    )
    # Noise and planes are told by all runs.
    np.testing.assert_allclose(first.gain, second.gain, rtol=5e-3)


def without_a_number(samples: Samples) -> Samples:
    readings = samples.readings.copy()
    readings[3, 2] = np.nan
    return replace(samples, readings=readings)


def dead_left_foot(samples: Samples) -> Samples:
    readings = samples.readings.copy()
    readings[:, samples.shoe.of_foot(0)] = 0.0
    return replace(samples, readings=readings)


def noise_alone(samples: Samples) -> Samples:
    rng = np.random.default_rng(0)
    return replace(samples, readings=rng.normal(size=samples.readings.shape))


@pytest.mark.parametrize(
    ("alter", "text"),
    [
        (without_a_number, "readings of left/rear_left are not numbers"),
        (dead_left_foot, "did not settle within 20 steps.*shoecal check SESSION"),
        (noise_alone, "did not settle within 20 steps.*shoecal check SESSION"),
    ],
)
def test_bad_readings_are_one_error(
    known: Drawn, alter: Callable[[Samples], Samples], text: str
) -> None:
    samples, guess = alter(known.fit.signal_model.samples), known.parameters
    with pytest.raises(ShoecalError, match=text) as caught, np.errstate(all="ignore"):
        fit_jointly(samples, samples.runs, guess, SETTINGS, TOLERANCES, 0.02)
    assert len(str(caught.value).splitlines()) == 1


def test_training_runs_without_samples_are_refused(known: Drawn) -> None:
    guess = known.parameters
    with pytest.raises(ShoecalError, match="no sample that can be fitted"):
        fit_jointly(known.fit.signal_model.samples, (99,), guess, SETTINGS, TOLERANCES, 0.02)


def test_another_run_counts_as_one_whose_own_unknowns_are_drawn_anew(known: Drawn) -> None:
    """The same as unknowns and rows of a second recording, written out."""
    system = known.fit.system
    run = system.recorded[0]
    rows = system.rows[:, system.runs == run]
    again = np.concatenate((np.where(system.own[:, None], 0.0, rows), rows[system.own]))
    first = np.concatenate((system.rows, np.zeros((system.own.sum(), system.rows.shape[1]))))
    whole = np.concatenate((first, again), axis=1)
    std = np.concatenate((system.std, system.std[system.own]))
    expected = Posterior(whole @ whole.T, std**-2.0).covariance[: len(system.std)]
    found = system.covariance_with_another(run)
    units = np.sqrt(np.outer(*2 * (np.diag(system.covariance()),)))
    np.testing.assert_allclose(
        found / units, expected[:, : len(system.std)] / units, rtol=0.0, atol=1e-6
    )


def test_another_run_makes_all_more_certain_and_changes_no_value(known: Drawn) -> None:
    fit = known.fit
    for run in fit.system.recorded:
        more = fit.with_another(run)
        assert (np.diag(more.covariance) <= np.diag(fit.covariance) * (1.0 + 1e-6)).all()
        assert more.covariance.trace() < fit.covariance.trace()
        np.testing.assert_array_equal(more.vector, fit.vector)
