"""All signals of a session under one set of channel parameters, and what may always be in them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources import body
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.responses import Responses
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signals import (
    AIR,
    CLOSURE,
    COP,
    FLAT,
    FLAT_OF_CLOSURE,
    GRF,
    OWN_ERRORS,
    PARITY,
    SIGNALS,
    TILT,
)
from shoecal_core.error_sources.wiring import Wiring
from shoecal_core.samples.samples import Samples
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import ChannelParameters


def cell_planes(
    samples: Samples, parameters: ChannelParameters, settings: SignalSettings
) -> FloatArray:
    """(2, n) direction in which the outputs of a foot's four cells hardly vary.

    Found by principal components over the samples in which the foot stands; used only where
    the rest is small, as it is for cells below a stiff plate.
    """
    shoe = samples.shoe
    planes = np.zeros((len(FEET), len(shoe.channels)))
    outputs = parameters.outputs(samples.readings)
    for foot in range(len(FEET)):
        own = [i for i in shoe.of_foot(foot) if shoe.columns[i, 0] == 1.0 and not shoe.torque[i]]
        part = outputs[samples.loaded[:, foot]][:, own]
        if len(own) != 4 or len(part) < 10:
            continue
        _, size, directions = np.linalg.svd(part - part.mean(axis=0), full_matrices=False)
        if size[3] <= settings.parity_residual * size[2]:
            planes[foot, own] = directions[3]
    return planes


FREE = 1e6
"""Prior of what may have any size."""
LEAST_STANDING_M, LEAST_STANDING_RAD, BRACED_SHARE = 1e-4, 4e-4, 5e-4
"""Least scatter from stance to stance of CoP and tilt, and that of the vertical force over it."""
LEAST_FLAT = (1e-4, 1e-3, 1e-3)
"""The same of how flat the soles stand: height [m], roll and pitch [rad]."""


@dataclass(frozen=True)
class Nuisance:
    """What may be in any recording and is fitted with whatever else is.

    Attributes:
        column: (T, s) what one unit of it adds.
        std: prior standard deviation.
        shared: by all runs, or it belongs to one run or stance.
        as_built: it is a deviation of a robot as built.
    """

    column: FloatArray
    std: float
    shared: bool = True
    as_built: bool = False


@dataclass(frozen=True)
class SignalModel(Responses):
    """All signals at T samples under one set of channel parameters.

    Attributes:
        zero_std: how well the joints' zeros are set [rad].
        deviations: as-built errors that are nuisances here.
    """

    zero_std: float
    deviations: tuple[Deviation, ...] = ()

    @cached_property
    def residuals(self) -> FloatArray:
        """(T, s) measured minus modelled, in the signals' units; zero where a signal is missing."""
        samples = self.samples
        found = np.zeros((len(samples.run), len(SIGNALS)))
        found[:, GRF] = (self.wrench[:, 0] - samples.force)[:, None]
        found[:, COP] = self.cop - samples.cop
        found[:, AIR] = self.hanging(self.foot_wrenches)
        found[:, CLOSURE] = body.closure(samples.states)
        found[:, PARITY] = self.outputs @ self.planes.T
        up = np.where(np.isfinite(samples.up), samples.up, 0.0)
        found[:, TILT] = body.up_in_sole(samples.states, samples.frame, up)[:, :2]
        return self.settled(found)

    @cached_property
    def baseline(self) -> FloatArray:
        """(p, T, s) derivatives by gains and offsets; then what `nuisances` may add."""
        count, channels = self.outputs.shape
        gains = [self._of_channel(i, one) for i, one in enumerate(self.samples.readings.T)]
        offsets = [self._of_channel(i, np.ones(count)) for i in range(channels)]
        others = [one.column for one in self.nuisances]
        return np.array([self.settled(one) for one in (*gains, *offsets, *others)])

    def _of_channel(self, channel: int, values: FloatArray) -> FloatArray:
        change = np.zeros_like(self.outputs)
        change[:, channel] = values
        column = self.by_outputs(change, settled=False)
        # Which way a plane leans is found from the outputs, whatever the gains.
        column[:, PARITY] = 0.0
        return column

    @cached_property
    def nuisances(self) -> list[Nuisance]:
        """Deviations as built, and what may be there in any recording."""
        count = len(self.samples.run)
        found = [
            Nuisance(one.column, one.std, shared=one.run is None, as_built=True)
            for one in self.deviations
        ]

        def add(signal: int, values: FloatArray, std: float, *, shared: bool = True) -> None:
            column = np.zeros((count, len(SIGNALS)))
            column[:, signal] = values
            found.append(Nuisance(column, std, shared))

        for foot in (0, 1):
            own = np.flatnonzero(self.wiring.foot == foot)
            if self.planes[foot].any():
                others = np.linalg.svd(self.planes[foot, own][None])[2][1:]
                for values in (*(self.outputs[:, own] @ others.T).T, np.ones(count)):
                    add(PARITY.start + foot, values, FREE)
        # Accelerations move the zero-moment point; how much is roughly as of a rigid body.
        if not self.fast:
            found.append(Nuisance(self.dynamic, FREE))
        for axis in range(TILT.start, TILT.stop):
            add(axis, np.ones(count), FREE)
        for axis, std in enumerate(self.zero_errors, FLAT.start):
            add(axis, np.ones(count), std)
        # Encoders stand on one step or the next for a whole stance: an error of its own.
        steps = self.standing_errors
        for segment in self.slow_segments:
            here = (self.samples.segment == segment).astype(np.float64)
            for signal in OWN_ERRORS:
                add(signal, here, steps[signal], shared=False)
        return found

    @cached_property
    def shared(self) -> BoolArray:
        """(p,) which of the baseline's columns all runs share."""
        own = np.ones(2 * len(self.parameters.gain), dtype=np.bool_)
        return np.concatenate((own, [one.shared for one in self.nuisances]))

    @cached_property
    def built(self) -> BoolArray:
        """(p,) which of them are deviations of a robot as built."""
        own = np.zeros(2 * len(self.parameters.gain), dtype=np.bool_)
        return np.concatenate((own, [one.as_built for one in self.nuisances]))

    @cached_property
    def zero_errors(self) -> FloatArray:
        """(3,) of height [m], roll and pitch [rad] between the soles, by errors of joint zeros."""
        answer = self.jacobians.closure[:, FLAT_OF_CLOSURE]
        spread: FloatArray = np.sqrt(np.mean(np.sum(answer**2, axis=2), axis=0))
        return self.zero_std * spread

    @cached_property
    def slow_segments(self) -> tuple[int, ...]:
        """Segments of slow runs; in a walk a stance's own error drowns in the dynamics."""
        samples = self.samples
        return tuple(np.unique(samples.segment[~samples.walks]).tolist())

    @cached_property
    def standing_errors(self) -> FloatArray:
        """(s,) standard deviation of what a stance adds to each signal by itself, in its unit.

        From the encoders' steps, each joint by itself; the vertical force has the scatter of a
        robot that braces its legs against each other.
        """
        step = self.samples.encoder_step / np.sqrt(12.0)
        found = np.zeros(len(SIGNALS))
        found[0] = BRACED_SHARE * float(self.samples.force.mean())
        for part, answer, least in (
            (COP, self.jacobians.cop, LEAST_STANDING_M),
            (TILT, self.jacobians.tilt, LEAST_STANDING_RAD),
            (FLAT, self.jacobians.closure[:, FLAT_OF_CLOSURE], np.array(LEAST_FLAT)),
        ):
            spread = np.sqrt(np.mean(np.sum((answer * step) ** 2, axis=2), axis=0))
            found[part] = np.maximum(spread, least)
        return found

    def with_parameters(self, parameters: ChannelParameters) -> SignalModel:
        """Under other gains and offsets."""
        return replace(self, parameters=parameters)

    def leaving_out(self, outliers: BoolArray) -> SignalModel:
        """Without values (T, s) that nothing explains, and those left out before."""
        return replace(self, outliers=self.outliers | outliers)

    def with_planes(self, settings: SignalSettings) -> SignalModel:
        """With the planes of the cells as the outputs now show them."""
        return replace(self, planes=cell_planes(self.samples, self.parameters, settings))


def make_signal_model(
    samples: Samples,
    parameters: ChannelParameters,
    settings: SignalSettings,
    without: frozenset[str] = frozenset(),
) -> SignalModel:
    """The signal_model under first parameters; planes are found from the readings."""
    shoe = samples.shoe
    return SignalModel(
        samples=samples,
        parameters=parameters,
        jacobians=body.joint_jacobians(samples),
        planes=cell_planes(samples, parameters, settings),
        without=without,
        wiring=Wiring(shoe.columns, shoe.foot),
        zero_std=settings.joint_zero_rad,
        outliers=np.zeros((len(samples.run), len(SIGNALS)), dtype=np.bool_),
    )
