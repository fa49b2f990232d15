"""Recordings made up from known gains and offsets: what a fit must find again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    combined,
    cop,
    foot_wrenches,
    weight_below,
)

SUPPORTS = (
    DoubleSupport(0.00, -0.10, 0.0),
    DoubleSupport(0.06, -0.12, -0.4),
    DoubleSupport(-0.03, -0.14, 0.3),
    DoubleSupport(0.03, -0.11, -0.2),
    DoubleSupport(-0.02, -0.13, 0.5),
)
STRAIGHT = (
    DoubleSupport(0.00, -0.10, 0.0),
    DoubleSupport(0.05, -0.13, 0.0),
    DoubleSupport(-0.03, -0.15, 0.0),
)
RATE = 20.0
"""1/s; samples of one run."""

EXACT = CalibrationSettings(force_std_n=1e-4, cop_std_m=1e-6)
"""Trust in the samples far above that in the initial guess: for samples without error."""


def truth(shoe: Shoe, rng: np.random.Generator) -> ChannelParameters:
    """Gains spread by 30 % with the shoe's polarities, offsets of some newtons."""
    sign = np.where(shoe.polarity == 0, 1, shoe.polarity)
    gain = 25.0 * rng.uniform(0.7, 1.3, len(sign)) * sign
    return ChannelParameters(gain, rng.uniform(-8.0, 8.0, len(sign)))


def common(shoe: Shoe, gain: float, offset: float, sign: IntArray) -> ChannelParameters:
    """One law for all channels, some of them upside down."""
    return ChannelParameters(np.asarray(gain * sign), np.full(len(shoe.channels), offset))


def cell_forces(
    shoe: Shoe, time: FloatArray, rng: np.random.Generator, weight: float
) -> FloatArray:
    """(T, n) forces under a body that sways slowly over both feet, not confined to a plane."""
    count = len(shoe.channels)
    pace, start = rng.uniform(0.5, 3.0, count), rng.uniform(0.0, 6.0, count)
    shares = 1.2 + np.sin(np.round(2.0 * pace) * time[:, None] * 2.0 * np.pi / 20.0 + start)
    return np.asarray(weight * shares / shares.sum(axis=1, keepdims=True))


def stance(
    shoe: Shoe,
    parameters: ChannelParameters,
    support: DoubleSupport,
    rng: np.random.Generator,
    *,
    run: int = 1,
    count: int = 400,
    rate: float = RATE,
    weight: float = 54.0,
    noise: float = 0.0,
    late: float = 0.0,
) -> Stance:
    """One run in double support whose model is exact.

    Args:
        noise: of the readings, in newtons.
        late: the model's samples tell what was true this long before [s].
    """
    time = np.arange(count) / rate
    seed = int(rng.integers(2**32))  # one draw a run, however many samples it has
    forces, then = (
        cell_forces(shoe, moment, np.random.default_rng(seed), weight)
        for moment in (time, time - late)
    )
    wrench = combined(foot_wrenches(shoe, then), support)
    noisy = forces + noise * np.random.default_rng([seed, 1]).standard_normal(forces.shape)
    return make_stance(
        run,
        shoe,
        support,
        (True, True),
        time,
        (noisy - parameters.offset) / parameters.gain,
        wrench[:, 0],
        cop(wrench, 0.0),
    )


def stances(
    shoe: Shoe,
    parameters: ChannelParameters,
    rng: np.random.Generator,
    supports: Sequence[DoubleSupport] = SUPPORTS,
    **options: float,
) -> list[Stance]:
    """One run a support."""
    return [
        stance(shoe, parameters, support, rng, run=index + 1, **options)  # type: ignore[arg-type]
        for index, support in enumerate(supports)
    ]


def single_stance(
    shoe: Shoe,
    parameters: ChannelParameters,
    foot: int,
    rng: np.random.Generator,
    *,
    run: int = 1,
    count: int = 100,
    weight: float = 54.0,
    swing: float = 0.0,
) -> Stance:
    """One foot carries the robot, the other hangs; `swing` shakes the weight by that share."""
    time = np.arange(count) / RATE
    outputs = np.zeros((count, len(shoe.channels)))
    own = shoe.of_foot(foot)
    hanging = shoe.of_foot(1 - foot)
    lift = 1.0 + swing * np.sin(2.0 * time)
    outputs[:, own] = cell_forces(shoe, time, rng, weight)[:, own] * lift[:, None]
    outputs[:, hanging] = -np.linalg.pinv(shoe.columns[hanging].T) @ weight_below(shoe)[1 - foot]
    wrench = foot_wrenches(shoe, outputs)[:, foot]
    loaded = (foot == 0, foot == 1)
    readings = (outputs - parameters.offset) / parameters.gain
    return make_stance(
        run, shoe, SUPPORTS[0], loaded, time, readings, wrench[:, 0], cop(wrench, 0.0)
    )


def with_corrections(
    stance: Stance, shoe: Shoe, parameters: ChannelParameters, corrections: list[CopCorrection]
) -> Stance:
    """The same run on a floor where the corrected CoP is the true one."""
    measured = Sensing(shoe, parameters, corrections).measure(stance.readings)
    place = measured.combined_cop(stance.support)
    return replace(stance, cop=place, cop_rate=np.gradient(place, stance.time, axis=0))


def with_model_noise(
    stance: Stance, rng: np.random.Generator, force: float, place: float
) -> Stance:
    """The same run with white errors of the modelled force [N] and CoP [m]."""
    return replace(
        stance,
        force=stance.force + force * rng.standard_normal(stance.force.shape),
        cop=stance.cop + place * rng.standard_normal(stance.cop.shape),
    )
