"""Gains and offsets, fitted together with everything that a robot as built may have wrong.

    measured - modelled = J_b (b - b0) + tau C_m' + sum_k J_k x_k + form error + noise

with b the gains and offsets (prior about the initial guess), tau the time offset of the joints,
x_k ~ N(0, as-built^2) the deviations of `error_sources.as_built`, in all signals of
`error_sources.signals`. The form error is what no linear source has in its form: alike for
`correlation_s`, so that the samples within it count as one. Gauss-Newton; the prior makes every
step well defined.

Samples are means over 1 / RATE_HZ: the noise of single readings would bias the gains towards zero
(errors in variables: Fuller, Measurement Error Models, 1987, ch. 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.as_built import of_body
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.noise import model_error, white_noise
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel, make_signal_model
from shoecal_core.error_sources.signals import COP
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.known import KnownShoe, KnownZeros
from shoecal_core.estimation.linear_system import LinearSystem
from shoecal_core.samples.samples import Samples, Track
from shoecal_core.shoe.priors import parameter_std
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

RATE_HZ = 1.0
"""Of the means that are fitted."""
COARSE, SETTLED = 1e-2, 1e-4
"""Largest step, in units of the parameters' priors, after which the derivatives of the body and
the noise are computed again, and at which the fit has settled."""
MAX_STEPS = 20
EXACT_S = 1e-6
"""Standard deviation of a time offset that is held at zero."""


class UnsettledError(ShoecalError):
    """A fit whose steps do not become small: its signals contradict each other."""


@dataclass(frozen=True)
class FittedDeviation:
    """One deviation with its fitted value and standard deviation, in its unit."""

    deviation: Deviation
    value: float
    std: float


@dataclass(frozen=True)
class JointFit:
    """A joint fit of n channels' gains and offsets, the time offset and k deviations.

    The covariance's order is gains, offsets, time offset, deviations.

    Attributes:
        system: the problem as the last step solved it.
        signal_model: of all runs, at the fitted gains and offsets.
        time_offset: the joints are late by this [s].
        away: (2n + 1,) gains, offsets and time offset, less the middle of their priors.
        deviations: all k of them.
        covariance: (2n + 1 + k,) squared, if noise and form error are as stated.
        prior_std: (2n + 1 + k,).
        cost: sum of whitened squares, priors included.
        initial_cost: the same at the initial guess.
        steps: of Gauss-Newton.
        last_step: the largest component of the last one, in units of its prior.
        gradient_norm: largest derivative of the cost by gains and offsets before the last step, all
            else being fitted, in units of each one's standard deviation.
        residuals: (T, s) what neither deviations nor nuisances explain.
    """

    system: LinearSystem
    signal_model: SignalModel
    time_offset: float
    away: FloatArray
    deviations: tuple[FittedDeviation, ...]
    covariance: FloatArray
    prior_std: FloatArray
    cost: float
    initial_cost: float
    steps: int
    last_step: float
    gradient_norm: float
    residuals: FloatArray

    @property
    def parameters(self) -> ChannelParameters:
        """Gains and offsets."""
        return self.signal_model.parameters

    @property
    def vector(self) -> FloatArray:
        """(2n + 1,) gains, offsets, time offset."""
        return np.concatenate((self.parameters.gain, self.parameters.offset, [self.time_offset]))

    @cached_property
    def shoe(self) -> Shoe:
        """The shoe with the channels' columns as they were fitted."""
        shoe = self.signal_model.samples.shoe
        columns = shoe.columns.copy()
        for one in self.deviations:
            if one.deviation.shoe_column is not None:
                columns = columns + one.value * one.deviation.shoe_column
        return shoe.with_columns(columns)

    def with_another(self, run: int) -> JointFit:
        """The same values, as certain as they were had a training run been recorded twice."""
        covariance = _signed(self.system.covariance_with_another(run), self.system)
        return replace(self, covariance=covariance)

    @property
    def measuring(self) -> tuple[FloatArray, list[FloatArray]]:
        """Covariance (2n + d,) squared of gains, offsets and shoe deviations, and the (n, 3) that
        a unit of each of these d adds to the channels' columns.
        """
        own = list(range(len(self.vector) - 1))
        columns = []
        for index, one in enumerate(self.deviations, start=len(self.vector)):
            if one.deviation.shoe_column is not None:
                own.append(index)
                columns.append(one.deviation.shoe_column)
        return self.covariance[np.ix_(own, own)], columns

    @cached_property
    def model_shift(self) -> FloatArray:
        """(T, 2) by which links, joints and soles move the CoP that is to be measured [m]."""
        shift = np.zeros((len(self.residuals), 2))
        for one in self.deviations:
            if one.deviation.run is None and one.deviation.shoe_column is None:
                shift += one.value * one.deviation.column[:, COP]
        return shift

    @cached_property
    def information(self) -> FloatArray:
        """(2n + 1,) squared: the data's Fisher information, all deviations marginalised."""
        size = len(self.vector)
        whole = np.linalg.inv(self.covariance[:size, :size])
        whole -= np.diag(1.0 / self.prior_std[:size] ** 2)
        information: FloatArray = 0.5 * (whole + whole.T)
        return information


def fit_jointly(
    samples: Samples,
    train: Sequence[int],
    guess: ChannelParameters,
    settings: SignalSettings,
    tolerances: Tolerances,
    time_offset_std_s: float,
    known: KnownShoe | None = None,
    zeros: KnownZeros | None = None,
    without: frozenset[str] = frozenset(),
) -> JointFit:
    """Fit gains, offsets, time offset and deviations to the training runs.

    Args:
        samples: means of all runs.
        train: numbers of the runs to fit.
        guess: gains and offsets that the priors are about, and to start with.
        settings: priors, and the size of the form error.
        tolerances: how far robot and shoes may be off their files.
        time_offset_std_s: how far joints and readings may be apart in time [s].
        known: of the shoe, by a manual calibration; None: nothing.
        zeros: of a robot that hung; None: it did not.
        without: families of signals that are left out (`signals.FAMILIES`).

    Raises:
        ShoecalError: when there is nothing to fit, or a reading is no number.
        UnsettledError: when it does not settle.
    """
    fitted = np.isin(samples.run, train)
    if not fitted.any():
        raise ShoecalError(
            "the training runs have no sample that can be fitted: stand still for 0.8 s or longer"
        )
    lost = ~np.isfinite(samples.readings).all(axis=0)
    if lost.any():
        named = ", ".join(np.array(samples.shoe.names)[lost])
        raise ShoecalError(f"readings of {named} are not numbers: leave those samples out")
    signal_model = make_signal_model(samples, guess, settings, without).with_planes(settings)
    late = _time_offset_column(signal_model)
    own_std = np.append(
        parameter_std(samples.shoe, guess.gain, samples.robot.weight, settings),
        max(time_offset_std_s, EXACT_S),
    )
    steps, initial_cost = 0, None
    for tolerance in (COARSE, SETTLED):
        sample_std = sample_std_of(signal_model, settings)
        body = of_body(signal_model, tolerances)
        moved = np.inf
        while not moved < tolerance:  # nor where it is not a number
            if steps == MAX_STEPS:
                raise _unsettled(moved)
            try:
                system = LinearSystem.at(
                    signal_model,
                    fitted,
                    guess,
                    own_std,
                    late,
                    body,
                    sample_std,
                    tolerances,
                    known,
                    zeros,
                )
                if initial_cost is None:
                    initial_cost = system.cost(np.zeros(len(system.std)))
                solution = system.solution()
                moved = system.moved(solution)
                now = system.parameters_after(solution)
                signal_model = signal_model.with_parameters(now).with_planes(settings)
            except np.linalg.LinAlgError:  # steps that only grow
                raise _unsettled(moved) from None
            steps += 1
    assert initial_cost is not None
    return _joint_fit(system, signal_model, solution, initial_cost, steps, moved)


def _unsettled(moved: float) -> UnsettledError:
    return UnsettledError(
        f"the joint fit did not settle within {MAX_STEPS} steps (the last one was {moved:.1e} of "
        "the priors); run `shoecal check SESSION` to look for faults of the recording"
    )


def sample_std_of(signal_model: SignalModel, settings: SignalSettings) -> FloatArray:
    """(s,) of the samples: sensor noise, and the form error as if each sample erred by itself.

    Samples within the correlation time err alike; each therefore counts by its share only.
    """
    together = max(1.0, settings.correlation_s * RATE_HZ)
    std: FloatArray = np.hypot(
        white_noise(signal_model), np.sqrt(together) * model_error(signal_model, settings)
    )
    return std


def _time_offset_column(signal_model: SignalModel) -> FloatArray:
    """(T, s) a unit of the joints' time offset: the modelled CoP lags by its rate of change."""
    samples = signal_model.samples

    def rates(track: Track) -> FloatArray:
        rate: FloatArray = np.gradient(track.com[..., :2], track.time, axis=0)
        return rate

    both = samples.decimated(rates)
    column = np.zeros_like(signal_model.residuals)
    column[:, COP] = both[np.arange(len(both)), samples.frame]
    column[:, COP] *= ~samples.walks[:, None]
    return column * signal_model.mask


def _joint_fit(
    system: LinearSystem,
    signal_model: SignalModel,
    solution: FloatArray,
    initial_cost: float,
    steps: int,
    moved: float,
) -> JointFit:
    """The result, for a solution that has settled."""
    first = 2 * len(signal_model.parameters.gain) + 1
    size = first + len(system.deviations)
    covariance = _signed(system.covariance(), system)
    own = first - 1
    # The cost is quadratic about its minimum, which the last step leads to.
    gradient = 2.0 * np.linalg.solve(covariance[:own, :own], -solution[:own])
    stds = np.sqrt(np.diag(covariance))[first:]
    fitted = tuple(
        FittedDeviation(one, float(value), float(std))
        for one, value, std in zip(system.deviations, solution[first:size], stds, strict=True)
    )
    return JointFit(
        system=system,
        signal_model=signal_model,
        time_offset=float(solution[first - 1]),
        away=np.append(
            (system.away - solution)[: first - 1],
            solution[first - 1],
        ),
        deviations=fitted,
        covariance=covariance,
        prior_std=system.std[:size],
        cost=system.cost(solution),
        initial_cost=initial_cost,
        steps=steps,
        last_step=moved,
        gradient_norm=float(np.abs(np.sqrt(np.diag(covariance)[:own]) * gradient).max()),
        residuals=system.signal_model.residuals - np.tensordot(solution, system.columns, 1),
    )


def _signed(covariance: FloatArray, system: LinearSystem) -> FloatArray:
    """That of gains, offsets, time offset and deviations, of one of all unknowns of a system.

    Gains and offsets enter a system as what they are too large by.
    """
    own = 2 * len(system.signal_model.parameters.gain)
    sign = np.ones(own + 1 + len(system.deviations))
    sign[:own] = -1.0
    signed: FloatArray = covariance[: len(sign), : len(sign)] * np.outer(sign, sign)
    return signed
