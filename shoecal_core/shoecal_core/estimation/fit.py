"""The paper's self-calibration (VI): initial guess, nonlinear least squares, CoP correction.

`calibrate --method paper` ends here; `correction_fit` has its last step. The usual method fits
gains and offsets together with all that robot and shoes may have wrong (`joint`), from the same
initial guess. A walk is calibrated by the first two steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.estimation.correction_fit import fit_corrections
from shoecal_core.estimation.initial_guess import InitialGuess, initial_guess
from shoecal_core.estimation.least_squares import Fit, Prior, minimise
from shoecal_core.estimation.residuals import ResidualWeights, pack, rows_of, thinned, unpack
from shoecal_core.estimation.walking_fit import CommonZeros, fit_walk
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import PAPER, CalibrationSettings
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.priors import parameter_std
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

MOST_SAMPLES = 20_000
"""Of a least squares: model errors are correlated over seconds, so more samples add nothing."""


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
        fit = fit_walk(shoe, stances, prior_of(shoe, guess, stances, settings), zeros, settings)
    parameters, time_offset = unpack(fit.vector)
    return SelfCalibration(
        shoe=shoe,
        guess=guess,
        guess_with_weight=initial_guess(shoe, stances, weight_row=True),
        fit=fit,
        corrections=(
            fit_corrections(shoe, parameters, time_offset, stances, settings)
            if settings.method == PAPER
            else ()
        ),
    )


def fit_parameters(
    shoe: Shoe, stances: Sequence[Stance], guess: InitialGuess, settings: CalibrationSettings
) -> Fit:
    """Nonlinear least squares over all gains, offsets and the time offset (paper, eq. 18)."""
    rows = rows_of(thinned(stances, MOST_SAMPLES), shoe, ResidualWeights.of(settings))
    return minimise(rows, prior_of(shoe, guess, stances, settings))


def prior_of(
    shoe: Shoe, guess: InitialGuess, stances: Sequence[Stance], settings: CalibrationSettings
) -> Prior:
    """What is believed of gains, offsets and time offset before any sample of the fit.

    Args:
        shoe, guess: of n channels.
        stances: of the fit; only the robot's weight is taken from them.
        settings: how far all may be off.
    """
    forces = [stance.force for stance in stances if len(stance.time)]
    weight = float(np.concatenate(forces).mean()) if forces else 0.0
    own = parameter_std(shoe, guess.parameters.gain, weight, settings)
    return Prior(pack(guess.parameters, 0.0), np.append(own, settings.time_offset_std_s))
