"""Self-calibration as one computation: stances in, calibrated parameters out (paper, VI)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.correction_fit import fit_corrections
from shoecal_core.calibration.least_squares import Fit, Prior, minimise
from shoecal_core.calibration.residuals import Problem, Weights, pack, unpack
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.walking_fit import CommonZeros, fit_walk
from shoecal_core.estimation.initial_guess import InitialGuess, initial_guess
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.correction import CopCorrection
from shoecal_core.sensing.sensing import Sensing
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
TOLERANCE = 1e-9
"""Share of the cost; where a further step promises to save less, the fit ends."""
THINNED = 10
COARSE_SAMPLES = 20_000
"""With more samples, every tenth is fitted first: that ends so near the minimum that a step or two
over all of them are enough."""


@dataclass(frozen=True)
class SelfCalibration:
    """All stages of one self-calibration.

    Attributes:
        shoe: whose channels these are.
        guess: the initial guess from the CoP alone, as in the paper.
        guess_with_weight: the same with the weight's row, for comparison.
        fit: the nonlinear least squares; its vector holds gains, offsets, time offset.
        corrections: CoP corrections of the feet for which they help.
    """

    shoe: Shoe
    guess: InitialGuess
    guess_with_weight: InitialGuess
    fit: Fit
    corrections: tuple[CopCorrection, ...]

    @property
    def parameters(self) -> ChannelParameters:
        """Gains and offsets."""
        return unpack(self.fit.vector)[0]

    @property
    def time_offset(self) -> float:
        """Joints are late by this much against the readings [s]."""
        return unpack(self.fit.vector)[1]

    @property
    def sensing(self) -> Sensing:
        """The measuring side with everything fitted."""
        return Sensing(self.shoe, self.parameters, self.corrections)


def self_calibrate(
    shoe: Shoe,
    stances: Sequence[Stance],
    settings: CalibrationSettings,
    zeros: CommonZeros | None = None,
) -> SelfCalibration:
    """Initial guess, nonlinear least squares, CoP correction.

    Args:
        shoe, stances, settings: of the fit.
        zeros: of a walk, that its stances were brought to; None: of a robot that moves slowly.

    Raises:
        ShoecalError: when the samples cannot be fitted at all.
    """
    guess = initial_guess(shoe, stances, weight_row=False)
    if zeros is None:
        fit = fit_parameters(shoe, stances, guess, settings)
    else:
        fit = fit_walk(shoe, stances, prior_of(shoe, guess, settings), zeros, settings)
    parameters, time_offset = unpack(fit.vector)
    return SelfCalibration(
        shoe=shoe,
        guess=guess,
        guess_with_weight=initial_guess(shoe, stances, weight_row=True),
        fit=fit,
        corrections=fit_corrections(shoe, parameters, time_offset, stances, settings),
    )


def fit_parameters(
    shoe: Shoe, stances: Sequence[Stance], guess: InitialGuess, settings: CalibrationSettings
) -> Fit:
    """Nonlinear least squares over all gains, offsets and the time offset (paper, eq. 18)."""
    weights = Weights.of(settings)
    problem = Problem.of(stances, shoe, weights)
    return _minimum(problem, prior_of(shoe, guess, settings), settings.max_iterations)


def _minimum(problem: Problem, prior: Prior, max_iterations: int) -> Fit:
    start = None
    if problem.samples > COARSE_SAMPLES:
        start = _minimum(problem.thinned(THINNED), prior, max_iterations).vector
    return minimise(
        problem.normal,
        prior,
        max_iterations=max_iterations,
        tolerance=TOLERANCE,
        cost=problem.cost,
        start=start,
    )


def prior_of(shoe: Shoe, guess: InitialGuess, settings: CalibrationSettings) -> Prior:
    """What is believed of gains, offsets and time offset before any sample of the fit."""
    known = np.array([channel.nominal_gain is not None for channel in shoe.channels])
    gain_std = np.abs(guess.parameters.gain) * np.where(
        known, settings.nominal_gain_std, settings.gain_std
    )
    offset_std = np.full(len(known), settings.offset_std_n)
    # A torque's offset is expected as large as the force's at a lever of 10 cm.
    offset_std[shoe.torque] *= 0.1
    return Prior(
        pack(guess.parameters, 0.0),
        np.concatenate((gain_std, offset_std, [settings.time_offset_std_s])),
    )
