"""Effects outside the library whose laws are drawn.

Cells of one foot show, in addition to their force, a random function of what they should not know.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from blind.felt import Felt
from blind.functions import Smooth
from blind.laws import Law, added
from shoecal_core.arrays import FloatArray

Generator = np.random.Generator

MOST = 0.5
"""Largest size: part of the largest load that a cell shows too much, by standard deviation."""


def _of_channels(felt: Felt, foot: int, rng: Generator) -> FloatArray:
    """(T,) a smooth function of two cells of the other foot."""
    pair = rng.permutation(felt.shoe.of_foot(1 - foot))[:2]
    loads = felt.forces[:, pair] / felt.forces.max()
    return Smooth.drawn(rng.uniform(0.15, 0.5), rng, 2)(loads)


def _of_speed(felt: Felt, foot: int, rng: Generator) -> FloatArray:
    """(T,) a smooth function of how fast the joints move, two random sums of them."""
    del foot
    sums = felt.speeds @ rng.standard_normal((felt.speeds.shape[1], 2))
    own = Smooth.drawn(rng.uniform(0.5, 2.0), rng, 2)
    return own(sums / sums.std(axis=0)) - own(np.zeros((1, 2)))


def _of_time(felt: Felt, foot: int, rng: Generator) -> FloatArray:
    """(T,) a smooth function of the time since a run began, the same in every run."""
    del foot
    return Smooth.drawn(rng.uniform(2.0, 10.0), rng)(felt.since)


FUNCTIONS: Mapping[str, Callable[[Felt, int, Generator], FloatArray]] = {
    "function of other cells": _of_channels,
    "function of joint speeds": _of_speed,
    "function of time in the run": _of_time,
}
"""Kinds by name."""


def unknown_law(felt: Felt, kind: str, seed: int) -> Law:
    """The law that a seed draws of a kind. Size: as MOST."""
    rng = np.random.default_rng(seed)
    foot = int(rng.integers(2))
    channels = felt.shoe.of_foot(foot)
    ear = rng.uniform(0.4, 1.6, len(channels)) * rng.choice([-1.0, 1.0], len(channels))
    unit = felt.forces.max() * FUNCTIONS[kind](felt, foot, rng)[:, None] * ear
    return added(felt, channels, unit, MOST)
