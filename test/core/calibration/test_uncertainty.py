"""Uncertainty of a fit: against many recordings, and against models made wrong on purpose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.calibration import synthetic
from core.model import robots
from core.sensing import shoes
from shoecal_core.calibration.fit import fit_parameters
from shoecal_core.calibration.residuals import Weights, pack, residuals, unpack
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.uncertainty import Uncertainty, estimate_uncertainty
from shoecal_core.error_sources.tolerances import ModelTolerances, Tolerances
from shoecal_core.estimation.expected import ErrorModel
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.model.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.sensing import Sensing
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


def fitted(
    shoe: Shoe,
    stances: list[Stance],
    tolerances: ModelTolerances | None = None,
    guessed_from: list[Stance] | None = None,
) -> tuple[ChannelParameters, Uncertainty]:
    guess = initial_guess(shoe, guessed_from or stances, weight_row=False)
    fit = fit_parameters(shoe, stances, guess, SETTINGS)
    return unpack(fit.vector)[0], estimate_uncertainty(fit, stances, WEIGHTS, tolerances)


@pytest.mark.parametrize("time_constant", [0.02, 0.4])
def test_intervals_of_gains_hold_in_repeated_recordings(time_constant: float) -> None:
    """Noise correlated in time is not counted as so many samples."""
    shoe, rng = shoes.shoe("nao_shoe"), np.random.default_rng(8)
    truth = synthetic.truth(shoe, rng)
    clean = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:3])
    inside, ratios = [], []
    for _ in range(60):
        stances = [correlated(stance, rng, 0.001, time_constant) for stance in clean]
        found, uncertainty = fitted(shoe, stances)
        std = np.sqrt(np.diag(uncertainty.covariance))[: len(shoe.names)]
        error = np.abs(found.gain - truth.gain)
        inside.append(error < NORMAL_95 * std)
        ratios.append((error / std) ** 2)
    # Runs of 20 s: their own covariance in time is not known well.
    assert 0.87 <= np.mean(inside) <= 0.99
    assert 0.8 < np.sqrt(np.mean(ratios)) < 1.3


def nao() -> tuple[Robot, Shoe]:
    shoe = shoes.shoe("nao_shoe")
    return robots.load("nao"), shoe


def standing(robot: Robot, stances: list[Stance], rng: np.random.Generator) -> list[Stance]:
    """The same samples, with joint angles around the posture."""
    return [
        replace(
            stance,
            angles=robot.posture
            + 0.05 * rng.standard_normal((len(stance.time), len(robot.posture))),
        )
        for stance in stances
    ]


@pytest.fixture(scope="module")
def made() -> tuple[Robot, Shoe, ChannelParameters, list[Stance]]:
    robot, shoe = nao()
    rng = np.random.default_rng(4)
    truth = synthetic.truth(shoe, rng)
    clean = synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:3], weight=robot.weight)
    return robot, shoe, truth, standing(robot, clean, rng)


CAUSES = (
    "weight", "place of left/front_left along x", "place of right/rear_right along y",
    "plates of the left shoe along y", "sag along x", "zero of LAnkleRoll",
    "CoM of root_joint along x",
)  # fmt: skip


@pytest.mark.parametrize("cause", CAUSES)
def test_a_wrong_model_moves_the_fit_as_its_slope_says(
    made: tuple[Robot, Shoe, ChannelParameters, list[Stance]], cause: str
) -> None:
    """Measured minus modelled is made wrong by a cause; the parameters follow the slopes."""
    robot, shoe, _, stances = made
    model = ModelTolerances(robot, shoe, Tolerances())
    found, uncertainty = fitted(shoe, stances, model)
    column = model.causes.index(cause)
    size = 0.1
    wrong = []
    for stance in stances:
        effects = model.effects(stance, found)
        wrong.append(
            replace(
                stance,
                cop=stance.cop - size * effects.cop[:, :, column],
                force=stance.force - size * effects.force[:, column],
            )
        )
    moved, _ = fitted(shoe, wrong, guessed_from=stances)
    # Compared by what they do to GRF and CoP: patterns of offsets that do nothing are nobody's.
    _, jacobian = residuals(pack(found, 0.0), stances[0], WEIGHTS)
    foretold = jacobian @ uncertainty.slopes[:, column] * size
    happened = jacobian @ (pack(moved, 0.0) - pack(found, 0.0))
    np.testing.assert_allclose(happened, foretold, atol=0.05 * np.abs(foretold).max())


def test_tolerances_never_grow_where_the_residuals_show_less(
    made: tuple[Robot, Shoe, ChannelParameters, list[Stance]],
) -> None:
    """A perfect fit leaves room only for errors that no residual can show."""
    robot, shoe, _, stances = made
    _, uncertainty = fitted(shoe, stances, ModelTolerances(robot, shoe, Tolerances()))
    values = np.linalg.eigvalsh(uncertainty.agreed)
    assert values.min() > -1e-12
    assert np.trace(uncertainty.agreed) < len(uncertainty.causes)
    assert uncertainty.covariance.shape == (17, 17)
    np.testing.assert_allclose(uncertainty.covariance, uncertainty.covariance.T, atol=1e-9)


def test_a_bad_model_widens_what_it_can_explain(
    made: tuple[Robot, Shoe, ChannelParameters, list[Stance]],
) -> None:
    robot, shoe, _, stances = made
    rng = np.random.default_rng(6)
    model = ModelTolerances(robot, shoe, Tolerances())
    bad = [correlated(stance, rng, 0.02, 30.0) for stance in stances]
    _, good_fit = fitted(shoe, stances, model)
    _, bad_fit = fitted(shoe, bad, model)
    assert np.trace(bad_fit.agreed) > np.trace(good_fit.agreed)


def test_without_joint_angles_the_model_has_no_part() -> None:
    robot, shoe = nao()
    rng = np.random.default_rng(5)
    stances = synthetic.stances(shoe, synthetic.truth(shoe, rng), rng)
    parameters, uncertainty = fitted(shoe, stances, ModelTolerances(robot, shoe, Tolerances()))
    assert uncertainty.causes == ()
    assert not uncertainty.model.any()
    both, *_ = ErrorModel(
        parameters, uncertainty, ModelTolerances(robot, shoe, Tolerances())
    ).over_polygons()
    assert np.isfinite(both.cop_length).all()


def test_expected_errors_are_those_of_shoes_made_wrong(
    made: tuple[Robot, Shoe, ChannelParameters, list[Stance]],
) -> None:
    """Tolerances drawn at random: the fit follows its slopes, and the CoP is off as foretold."""
    robot, shoe, truth, stances = made
    rng = np.random.default_rng(7)
    model = ModelTolerances(robot, shoe, Tolerances())
    parameters, found = fitted(shoe, stances, model)
    count = len(shoe.names)
    quiet = replace(found, noise=np.zeros_like(found.noise), prior=np.zeros_like(found.prior))
    few = stances[0].part(slice(None, None, 40))
    outputs = truth.outputs(few.readings)
    foretold = ErrorModel(parameters, quiet, model).foot(outputs, 0)
    shifts = model.measured_effects(outputs, few.support, found.placing).foot_cop[:, 0]
    root = np.linalg.cholesky(found.agreed + 1e-12 * np.eye(len(found.causes)))
    exact = Sensing(shoe, truth).measure(few.readings).cop[:, 0]
    errors = []
    for _ in range(400):
        drawn = 0.05 * root @ rng.standard_normal(len(found.causes))
        moved = (found.slopes @ drawn)[: 2 * count]
        wrong = ChannelParameters(truth.gain + moved[:count], truth.offset + moved[count:])
        measured = Sensing(shoe, wrong).measure(few.readings).cop[:, 0]
        errors.append(measured - exact + shifts @ drawn)
    np.testing.assert_allclose(np.std(errors, axis=0), 0.05 * foretold.cop, rtol=0.2)
