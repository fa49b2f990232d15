"""Self-calibration of made-up recordings: what was put in must come out again."""

from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation import fit as module
from shoecal_core.estimation.fit import fit_parameters, prior_of, self_calibrate
from shoecal_core.estimation.initial_guess import InitialGuess, initial_guess
from shoecal_core.estimation.least_squares import Fit
from shoecal_core.estimation.residuals import ResidualWeights, pack, rows_of, unpack
from shoecal_core.estimation.series import cop_mae
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    at_cop,
    combined,
    cop,
    foot_wrenches,
    weight_below,
)

EXACT = synthetic.EXACT
SEEN = {"nao_shoe": 14, "odd_shoe": 15, "wren_shoe": 12}
"""Directions of gains and offsets that GRF and CoP can ever tell."""


def fitted(shoe: Shoe, runs: Sequence[Stance], settings: CalibrationSettings = EXACT) -> Fit:
    guess = initial_guess(shoe, runs, weight_row=False)
    return fit_parameters(shoe, runs, guess, settings)


def foot_sums(shoe: Shoe, offset: FloatArray) -> FloatArray:
    """(2, 3) what offsets add to each foot's wrench: all of them that anybody can see."""
    return np.stack(
        [offset[shoe.of_foot(foot)] @ shoe.columns[shoe.of_foot(foot)] for foot in (0, 1)]
    )


# ---- exact recovery ---------------------------------------------------------------------------


def test_samples_without_error_give_the_parameters_back(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = synthetic.stances(shoe, truth, rng)
    fit = fitted(shoe, runs)
    found, late = unpack(fit.vector)
    np.testing.assert_allclose(found.gain, truth.gain, rtol=1e-8)
    np.testing.assert_allclose(
        foot_sums(shoe, found.offset), foot_sums(shoe, truth.offset), atol=1e-7
    )
    assert late == pytest.approx(0.0, abs=1e-9)
    # What nobody can see stays where the guess had it.
    start = initial_guess(shoe, runs, weight_row=False).parameters.offset
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        hidden = np.linalg.svd(shoe.columns[own].T)[2][3:]
        np.testing.assert_allclose(hidden @ found.offset[own], hidden @ start[own], atol=1e-4)


def test_grf_and_cop_are_right_where_the_fit_has_never_been(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    found, _ = unpack(fitted(shoe, synthetic.stances(shoe, truth, rng)).vector)
    for support in (DoubleSupport(0.02, -0.15, 0.25), synthetic.SUPPORTS[0]):
        other = synthetic.stance(shoe, truth, support, np.random.default_rng(77), weight=30.0)
        measured = Sensing(shoe, found).measure(other.readings)
        expected = Sensing(shoe, truth).measure(other.readings)
        np.testing.assert_allclose(measured.grf, expected.grf, atol=1e-6)
        np.testing.assert_allclose(measured.cop, expected.cop, atol=1e-7)
        np.testing.assert_allclose(measured.combined_cop(support), other.cop, atol=1e-8)


def test_the_fit_certifies_itself(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = synthetic.stances(shoe, truth, rng)
    settings = CalibrationSettings()
    fit = fitted(shoe, runs, settings)
    weights = ResidualWeights.of(settings)
    errors, jacobian = rows_of(runs, shoe, weights)(fit.vector)
    np.testing.assert_allclose(fit.information, jacobian.T @ jacobian, rtol=1e-9, atol=1e-6)
    assert errors @ errors <= fit.cost < 1e-2 * fit.initial_cost
    assert fit.gradient_norm < 1e-3
    std = np.sqrt(np.diag(fit.covariance))
    correlation = fit.covariance / np.outer(std, std)
    np.testing.assert_allclose(correlation, correlation.T, atol=1e-9)
    assert np.linalg.eigvalsh(correlation).min() > 0.0


@pytest.mark.parametrize("weight", [20.0, 54.0, 600.0])
def test_robots_of_any_weight(weight: float, rng: np.random.Generator) -> None:
    shoe = shoes.shoe("odd_shoe")
    truth = synthetic.truth(shoe, rng)
    truth = ChannelParameters(truth.gain * weight / 54.0, truth.offset * weight / 54.0)
    fit = fitted(shoe, synthetic.stances(shoe, truth, rng, weight=weight))
    np.testing.assert_allclose(unpack(fit.vector)[0].gain, truth.gain, rtol=1e-6)


def test_some_of_many_samples_tell_the_same(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    clean = synthetic.stances(shoe, truth, rng, noise=0.05)
    settings = CalibrationSettings()
    plain = fitted(shoe, clean, settings)
    monkeypatch.setattr(module, "MOST_SAMPLES", 500)
    thinned = fitted(shoe, clean, settings)
    std = np.sqrt(np.diag(plain.covariance))
    np.testing.assert_allclose((thinned.vector - plain.vector) / std, 0.0, atol=0.3)
    np.testing.assert_allclose(np.sqrt(np.diag(thinned.covariance)), std, rtol=0.05)


# ---- what the data can tell -------------------------------------------------------------------

FIXED_TIME = replace(EXACT, time_offset_std_s=0.0)


@pytest.mark.parametrize("count", [3, 5])
def test_supports_that_differ_in_yaw_tell_all_there_is(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, count: int
) -> None:
    runs = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:count])
    assert fitted(shoe, runs, FIXED_TIME).rank == SEEN[shoe.name]
    # Swaying samples tell the time offset too.
    assert fitted(shoe, runs, EXACT).rank == SEEN[shoe.name] + 1


@pytest.mark.parametrize(
    ("supports", "missing"),
    [(synthetic.SUPPORTS[:1], 3), (synthetic.SUPPORTS[:2], 1), (synthetic.STRAIGHT, 2)],
    ids=["one", "two", "straight"],
)
def test_with_less_left_and_right_trade_off(
    truth: ChannelParameters, shoe: Shoe, rng: np.random.Generator,
    supports: Sequence[DoubleSupport], missing: int,
) -> None:  # fmt: skip
    """A force f and moments m on the right foot, taken back on the left: nothing shows when
    R m + t x f is the same in every support. Three unknowns, two equations for each further
    support, none of them about m without yaw.
    """
    runs = synthetic.stances(shoe, truth, rng, supports)
    fit = fitted(shoe, runs, FIXED_TIME)
    assert fit.rank == SEEN[shoe.name] - missing
    # The sum looks right all the same, and each foot's CoP is wrong.
    found, _ = unpack(fit.vector)
    for run in runs:
        measured = Sensing(shoe, found).measure(run.readings)
        expected = Sensing(shoe, truth).measure(run.readings)
        np.testing.assert_allclose(measured.combined_cop(run.support), run.cop, atol=1e-6)
        assert np.nanmax(np.abs(measured.cop - expected.cop)) > 1e-4


def test_a_hanging_foot_fixes_its_offsets(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    """One support and both feet lifted once: as good as differing yaw."""
    runs = [
        *synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:1]),
        synthetic.single_stance(shoe, truth, 0, rng, run=2),
        synthetic.single_stance(shoe, truth, 1, rng, run=3),
    ]
    fit = fitted(shoe, runs, FIXED_TIME)
    assert fit.rank == SEEN[shoe.name]
    found, _ = unpack(fit.vector)
    np.testing.assert_allclose(found.gain, truth.gain, rtol=1e-6)
    np.testing.assert_allclose(
        foot_sums(shoe, found.offset), foot_sums(shoe, truth.offset), atol=1e-5
    )


def test_directions_that_only_the_prior_holds_keep_its_width(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    settings = replace(EXACT, force_std_n=1e-2, cop_std_m=1e-4)
    runs = synthetic.stances(shoe, truth, rng)
    fit = fitted(shoe, runs, settings)
    offset_std = prior_of(shoe, initial_guess(shoe, runs, weight_row=False), runs, settings).std[-2]
    hidden = fit.directions[fit.rank :]
    count = len(shoe.channels)
    assert len(hidden) == 2 * count + 1 - fit.rank
    for direction in hidden:
        # Offsets alone, and none that the wrench of a foot would show.
        np.testing.assert_allclose(direction[:count] / truth.gain, 0.0, atol=1e-6)
        np.testing.assert_allclose(
            foot_sums(shoe, direction[count:-1]) / offset_std, 0.0, atol=1e-6
        )
        whitened = direction / offset_std**2
        variance = whitened @ fit.covariance @ whitened
        assert variance == pytest.approx(1.0, rel=1e-3)


def test_without_data_the_fit_stays_at_the_guess(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = synthetic.stances(shoe, truth, rng)
    guess = initial_guess(shoe, runs, weight_row=False)
    for nothing in ([], [runs[0].part(slice(0, 0))]):
        fit = fit_parameters(shoe, nothing, guess, CalibrationSettings())
        np.testing.assert_array_equal(fit.vector, pack(guess.parameters, 0.0))
        assert fit.rank == 0
    sure = CalibrationSettings(gain_std=1e-6, offset_std_n=1e-6, time_offset_std_s=0.0)
    fit = fit_parameters(shoe, runs, guess, sure)
    np.testing.assert_allclose(unpack(fit.vector)[0].gain, guess.parameters.gain, rtol=1e-4)


def test_what_is_believed_before_any_sample() -> None:
    """Gains as a share of their guess, tighter from a data sheet; torques' offsets at 10 cm."""
    origin = [0.0, 0.0, 0.1]
    sensors = [*shoes.six_axis(0, origin, gain=2.0), *shoes.six_axis(1, origin, gain=None)]
    shoe = shoes.made(sensors)
    parameters = ChannelParameters(np.full(10, -2.0), np.full(10, 1.5))
    guess = InitialGuess(parameters, shoe.polarity, -2.0, 1.5)
    settings = CalibrationSettings()
    fit = fit_parameters(shoe, [], guess, settings)
    std = np.sqrt(np.diag(fit.covariance))
    np.testing.assert_allclose(std[:5], 2.0 * settings.nominal_gain_std)
    np.testing.assert_allclose(std[5:10], 2.0 * settings.gain_std)
    offsets = settings.offset_std_n * np.array([1.0, 1.0, 1.0, 0.1, 0.1] * 2)
    np.testing.assert_allclose(std[10:20], offsets)
    assert std[20] == pytest.approx(settings.time_offset_std_s)


# ---- time offset ------------------------------------------------------------------------------


@pytest.mark.parametrize("late", [-0.02, 0.005, 0.03])
def test_a_known_delay_is_found(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, late: float
) -> None:
    runs = synthetic.stances(shoe, truth, rng, late=late, rate=50.0, count=1000)
    # The model's CoP moves by one straight line a delay: its curvature is left over.
    settings = replace(EXACT, force_std_n=0.02, cop_std_m=1e-4, time_offset_std_s=0.1)
    fit = fitted(shoe, runs, settings)
    found, tau = unpack(fit.vector)
    assert tau == pytest.approx(late, abs=0.02 * abs(late) + 1e-5)
    np.testing.assert_allclose(found.gain, truth.gain, rtol=0.01)
    ignored = fitted(shoe, runs, replace(settings, time_offset_std_s=0.0))
    assert unpack(ignored.vector)[1] == 0.0
    assert ignored.cost > 2.0 * fit.cost


# ---- six axes ---------------------------------------------------------------------------------


def test_six_axis_feet_are_calibrated_by_the_same_fit(rng: np.random.Generator) -> None:
    origin = [0.01, 0.0, 0.1]
    shoe = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    count = 300
    time = np.arange(count) / synthetic.RATE
    truth = ChannelParameters(rng.uniform(0.9, 1.1, 10), rng.uniform(-3.0, 3.0, 10))
    runs = []
    for number, support in enumerate(synthetic.SUPPORTS):
        phase = rng.uniform(0.0, 6.0, 10)
        outputs = np.sin(rng.uniform(0.5, 2.0, 10) * time[:, None] + phase)
        outputs[:, [2, 7]] = 27.0 + 10.0 * outputs[:, [2, 7]] * [1.0, -1.0]
        wrench = combined(foot_wrenches(shoe, outputs), support)
        readings = (outputs - truth.offset) / truth.gain
        force, place = wrench[:, 0], cop(wrench, 0.0)
        runs.append(
            make_stance(number + 1, shoe, support, (True, True), time, readings, force, place)
        )
    fit = fitted(shoe, runs)
    found, _ = unpack(fit.vector)
    np.testing.assert_allclose(found.gain, truth.gain, rtol=1e-5)
    np.testing.assert_allclose(
        foot_sums(shoe, found.offset), foot_sums(shoe, truth.offset), atol=1e-4
    )


# ---- noise ------------------------------------------------------------------------------------


def test_the_covariance_is_the_scatter_of_repeated_fits() -> None:
    """White errors of the stated size, one independent sample each; well-seen directions."""
    shoe = shoes.shoe("nao_shoe")
    rng = np.random.default_rng(11)
    truth = synthetic.truth(shoe, rng)
    settings = CalibrationSettings(correlation_s=1.0 / synthetic.RATE)
    clean = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:3], count=120)
    guess = initial_guess(shoe, clean, weight_row=False)
    target = pack(truth, 0.0)
    scores = []
    for _ in range(60):
        runs = [
            synthetic.with_model_noise(run, rng, settings.force_std_n, settings.cop_std_m)
            for run in clean
        ]
        fit = fit_parameters(shoe, runs, guess, settings)
        scale = np.linalg.norm(fit.directions, axis=0)
        whitened = fit.directions / scale**2
        off = whitened @ (fit.vector - target)
        clear = fit.singular_values > 5.0
        predicted = np.sqrt(1.0 / (1.0 + fit.singular_values**2))
        assert clear.sum() >= 12
        scores.append((off / predicted)[clear])
        # The covariance says the same in parameters.
        np.testing.assert_allclose(
            np.einsum("ki,ij,kj->k", whitened, fit.covariance, whitened), predicted**2, rtol=1e-6
        )
    found = np.concatenate(scores)
    assert np.mean(found**2) == pytest.approx(1.0, abs=0.2)
    assert np.abs(found).max() < 5.0


def test_more_samples_of_one_error_are_not_more_evidence(
    shoe: Shoe, truth: ChannelParameters
) -> None:
    """The same runs at 20 and at 100 samples a second: the same fit, the same certainty."""

    def at(rate: float) -> Fit:
        draw, three = np.random.default_rng(2), synthetic.SUPPORTS[:3]
        runs = synthetic.stances(shoe, truth, draw, three, rate=rate, count=round(20 * rate))
        return fitted(shoe, runs, CalibrationSettings())

    slow, fast = at(20.0), at(100.0)
    std = np.sqrt(np.diag(slow.covariance))
    np.testing.assert_allclose(np.sqrt(np.diag(fast.covariance)), std, rtol=0.02)
    np.testing.assert_allclose((fast.vector - slow.vector) / std, 0.0, atol=0.05)


# ---- all stages -------------------------------------------------------------------------------


def test_all_stages_together(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    runs = synthetic.stances(shoe, truth, rng, noise=0.02)
    stages = self_calibrate(shoe, runs, CalibrationSettings())
    assert stages.shoe is shoe
    np.testing.assert_array_equal(stages.parameters.gain, unpack(stages.fit.vector)[0].gain)
    assert stages.time_offset == stages.fit.vector[-1]
    assert stages.sensing.corrections == stages.corrections
    assert stages.guess.gain != stages.guess_with_weight.gain

    def off(sensing: Sensing) -> float:
        found = [sensing.measure(run.readings).combined_cop(run.support) for run in runs]
        return cop_mae(np.concatenate(found), np.concatenate([run.cop for run in runs])).mean

    assert off(stages.sensing) < 0.1 * off(Sensing(shoe, stages.guess.parameters))


def test_a_long_recording_is_never_worked_on_as_a_whole(rng: np.random.Generator) -> None:
    """Guess, fit and corrections of 50 s at 1 kHz a run take less than one Jacobian."""
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, rng)
    three = synthetic.SUPPORTS[:3]
    runs = synthetic.stances(shoe, truth, rng, three, rate=1e3, count=50_000, noise=0.02)
    tracemalloc.start()
    self_calibrate(shoe, runs, CalibrationSettings())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    samples = sum(len(run.time) for run in runs)
    assert peak < samples * 3 * 17 * 8


def test_the_weight_below_the_cells_is_not_taken_for_an_offset(rng: np.random.Generator) -> None:
    """With it the hanging foot reads zero after the fit."""
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, rng)
    found, _ = unpack(fitted(shoe, synthetic.stances(shoe, truth, rng)).vector)
    pull = -np.linalg.pinv(shoe.columns[:4].T) @ weight_below(shoe)[0]
    standing = np.linalg.pinv(shoe.columns[4:].T) @ (
        at_cop(np.asarray(54.0), np.array([0.02, 0.01])) - weight_below(shoe)[1]
    )
    readings = (np.concatenate((pull, standing)) - truth.offset) / truth.gain
    measured = Sensing(shoe, found).measure(readings)
    assert measured.grf[0] == pytest.approx(0.0, abs=1e-6)
    assert measured.grf[1] == pytest.approx(54.0, abs=1e-6)
    assert np.isnan(measured.cop[0]).all()
