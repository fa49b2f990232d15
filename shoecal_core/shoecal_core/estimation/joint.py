"""The joint fit as a step of a calibration: what it is given, and what follows from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.special import chdtri

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.checks.contradiction import contradiction
from shoecal_core.estimation.fit import SelfCalibration
from shoecal_core.estimation.initial_guess import InitialGuess
from shoecal_core.estimation.joint_fit import RATE_HZ, JointFit, UnsettledError, fit_jointly
from shoecal_core.estimation.known import KnownShoe, KnownZeros, Since
from shoecal_core.estimation.least_squares import Fit
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.settings import SampleSettings
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import Zero
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import columns_in_left, weight_below

FALSE_CHANGE = 1e-3
"""Chance that steady shoes are taken for changed ones."""
SAMPLING = SampleSettings(rate_hz=RATE_HZ)
"""How a session becomes the samples of the joint fit."""
EXACT = 1e-4
"""N, N m; standard deviation of zeros that are the same in all runs."""


def joint_calibration(
    samples: Samples,
    train: Sequence[int],
    guess: InitialGuess,
    settings: CalibrationSettings,
    tolerances: Tolerances,
    known: KnownShoe | None = None,
    hanging: Sequence[Zero] = (),
) -> JointFit:
    """Fit gains, offsets and all that robot and shoes may have wrong, from the initial guess.

    Args:
        samples: of all runs.
        train: runs to fit.
        guess: where it starts, and what gains and offsets are believed to be about.
        settings, tolerances: of the calibration.
        known: of the shoe, by a manual calibration.
        hanging: what feet read in runs in which both are in the air.

    Raises:
        UnsettledError: when it does not settle, with what contradicts the rest.
    """
    signals = SignalSettings(
        rate_hz=RATE_HZ,
        correlation_s=settings.correlation_s,
        gain_std=settings.gain_std,
        nominal_gain_std=settings.nominal_gain_std,
        offset_std_n=settings.offset_std_n,
        model_error_rad=settings.model_error_rad,
    )
    zeros = known_zeros(samples.shoe, hanging, tolerances)

    def solve(runs: Sequence[int], without: frozenset[str] = frozenset()) -> JointFit:
        return fit_jointly(
            samples,
            runs,
            guess=guess.parameters,
            settings=signals,
            tolerances=tolerances,
            time_offset_std_s=settings.time_offset_std_s,
            known=known,
            zeros=zeros,
            without=without,
        )

    try:
        return solve(train)
    except UnsettledError as error:
        why = contradiction(solve, samples, train, signals, tolerances)
        raise UnsettledError(f"the joint fit did not settle: {why}") from error


def known_zeros(shoe: Shoe, zeros: Sequence[Zero], tolerances: Tolerances) -> KnownZeros:
    """Force and both moments of each foot in the air.

    Args:
        shoe: with n channels.
        zeros: of runs in which both feet are in the air.
        tolerances: by which zeros differ from run to run.
    """
    count = len(shoe.names)
    run_zero = tolerances.run_zero_n * np.where(shoe.torque, TORQUE_LEVER_M, 1.0)
    columns, readings, below, std = [], [], [], []
    for zero in zeros:
        own = np.where((shoe.foot == zero.foot)[:, None], shoe.columns, 0.0).T
        felt = np.any(own != 0.0, axis=1)
        columns.append(own[felt])
        readings.append(np.tile(zero.reading, (int(felt.sum()), 1)))
        below.append(weight_below(shoe)[zero.foot][felt])
        std.append(np.maximum(np.sqrt((own[felt] ** 2) @ run_zero**2), EXACT))
    if not zeros:
        return KnownZeros(np.zeros((0, count)), np.zeros((0, count)), np.zeros(0), np.zeros(0))
    return KnownZeros(*(np.concatenate(part) for part in (columns, readings, below, std)))


def of_joint(
    joint: JointFit, guess: InitialGuess, guess_with_weight: InitialGuess
) -> SelfCalibration:
    """The stages of a calibration that is found by the joint fit.

    Args:
        joint: the fit.
        guess, guess_with_weight: where it began, and the same with the weight's row.
    """
    size = len(joint.vector)
    std = joint.prior_std[:size]
    values, vectors = np.linalg.eigh(joint.information * np.outer(std, std))
    order = np.argsort(values)[::-1]
    fit = Fit(
        vector=joint.vector,
        cost=joint.cost,
        initial_cost=joint.initial_cost,
        gradient_norm=joint.gradient_norm,
        covariance=joint.covariance[:size, :size],
        information=joint.information,
        singular_values=np.sqrt(np.clip(values[order], 0.0, None)),
        directions=vectors.T[order] * std,
        iterations=joint.steps,
    )
    return SelfCalibration(
        shoe=joint.shoe,
        guess=guess,
        guess_with_weight=guess_with_weight,
        fit=fit,
        corrections=(),
    )


def fit_with_known(
    solve: Callable[[KnownShoe], JointFit], known: KnownShoe
) -> tuple[JointFit, Since]:
    """The joint fit under the strictest hypothesis about the shoes that the data do not contradict.

    Each hypothesis contains the one before; the cost of a true one is larger by as much as chi
    squared of the parameters that it fixes.

    Args:
        solve: the fit, given what is known.
        known: of the shoe, by a manual calibration.

    Raises:
        ShoecalError: when it settles under none.
    """
    free = solve(known.under(Since.CHANGED))
    count = len(known.parameters.gain)
    for since, fixed in ((Since.STEADY, 2 * count), (Since.ZEROS, count)):
        with suppress(ShoecalError):
            joint = solve(known.under(since))
            if joint.cost - free.cost <= chdtri(fixed, FALSE_CHANGE):
                return joint, since
    return free, Since.CHANGED


def corrected(
    stances: Mapping[int, tuple[Stance, ...]], joint: JointFit, shoe: Shoe
) -> dict[int, tuple[Stance, ...]]:
    """Stances with the corrected reference, and with the columns of a shoe, by run."""
    samples, shift = joint.signal_model.samples, joint.model_shift
    found = {}
    for run, parts in stances.items():
        here = samples.run == run
        found[run] = tuple(
            _corrected(stance, shoe, samples.time[here], shift[here]) for stance in parts
        )
    return found


def _corrected(stance: Stance, shoe: Shoe, time: FloatArray, shift: FloatArray) -> Stance:
    if all(stance.loaded):
        columns = columns_in_left(shoe, stance.support)
    else:
        foot = stance.loaded.index(True)
        columns = np.where((shoe.foot == foot)[:, None], shoe.columns, 0.0)
    if not len(time):
        return replace(stance, columns=columns)
    moved = np.stack([np.interp(stance.time, time, axis) for axis in shift.T], axis=1)
    return replace(stance, cop=stance.cop + moved, columns=columns)
