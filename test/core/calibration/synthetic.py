"""Recordings made up from known gains and offsets: what a fit must find again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.stance import Stance, make_stance
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, combined, cop, foot_wrenches

FloatArray = NDArray[np.float64]

SUPPORTS = (
    DoubleSupport(0.00, -0.10, 0.0),
    DoubleSupport(0.06, -0.12, -0.4),
    DoubleSupport(-0.03, -0.14, 0.3),
    DoubleSupport(0.03, -0.11, -0.2),
    DoubleSupport(-0.02, -0.13, 0.5),
)


def truth(shoe: Shoe, rng: np.random.Generator) -> ChannelParameters:
    """Gains spread by 30 % with the shoe's polarities, offsets of some newtons."""
    sign = np.where(shoe.polarity == 0, 1, shoe.polarity)
    gain = 25.0 * rng.uniform(0.7, 1.3, len(sign)) * sign
    return ChannelParameters(gain, rng.uniform(-8.0, 8.0, len(sign)))


def cell_forces(shoe: Shoe, count: int, rng: np.random.Generator, weight: float) -> FloatArray:
    """(T, n) forces under a body that sways slowly over both feet, not confined to a plane."""
    phase = np.linspace(0.0, 2.0 * np.pi, count)[:, None]
    waves = rng.uniform(0.5, 3.0, len(shoe.names)), rng.uniform(0.0, 6.0, len(shoe.names))
    shares = 1.2 + np.sin(np.round(waves[0] * 2.0) * phase + waves[1])
    return weight * shares / shares.sum(axis=1, keepdims=True)


def stance(
    shoe: Shoe,
    parameters: ChannelParameters,
    support: DoubleSupport,
    rng: np.random.Generator,
    *,
    run: int = 1,
    count: int = 400,
    weight: float = 54.0,
    noise: float = 0.0,
) -> Stance:
    """One run in double support whose model is exact, with reading noise of `noise` newtons."""
    forces = cell_forces(shoe, count, rng, weight)
    wrench = combined(foot_wrenches(shoe, forces), support)
    noisy = forces + noise * rng.standard_normal(forces.shape)
    return make_stance(
        run,
        shoe,
        support,
        (True, True),
        np.arange(count) / 20.0,
        (noisy - parameters.offset) / parameters.gain,
        wrench[:, 0],
        cop(wrench, 0.0),
    )


def stances(
    shoe: Shoe, parameters: ChannelParameters, rng: np.random.Generator, **options: float
) -> list[Stance]:
    """One run a support."""
    return [
        stance(shoe, parameters, support, rng, run=index + 1, **options)  # type: ignore[arg-type]
        for index, support in enumerate(SUPPORTS)
    ]
