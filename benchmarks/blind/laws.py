"""Laws of cells and of their timing, each drawn from a space of functions for one set.

A law is as strong as its size says; which law it is hangs on the seed alone. `sizing` finds the
size, so that no law needs a table of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from blind.felt import Felt
from blind.functions import Smooth, bending, density, monotone
from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.shoe.shoe import FEET

Generator = np.random.Generator

OPERATORS = 24
"""Play operators of a hysteresis, or delays of a filter."""
LONGEST_S = 0.6
"""Of a delay."""


@dataclass(frozen=True)
class Law:
    """What the cells show of what they feel.

    Attributes:
        most: largest size.
        shown: (T, n) forces [N] at a size.
    """

    most: float
    shown: Callable[[float], FloatArray]


def added(felt: Felt, channels: IntArray, unit: FloatArray, most: float) -> Law:
    """A law that adds to channels (k,) its size times (T, k) [N]."""

    def shown(size: float) -> FloatArray:
        forces = felt.forces.copy()
        forces[:, channels] += size * unit
        return forces

    return Law(most, shown)


def _top(felt: Felt, channels: IntArray) -> float:
    """Largest load of a channel [N]."""
    return float(felt.forces[:, channels].max())


def nonlinearity(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Size: part of the way from the straight line to a monotone curve of the cell's range."""
    top = _top(felt, channels)
    load = felt.forces[:, channels] / top
    return added(felt, channels, top * (monotone(rng)(load) - load), 1.0)


def saturation(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Size: part of the cell's range above the knee, over which it bends until it is flat."""
    top, curve = _top(felt, channels), bending(rng)
    width = top * rng.uniform(0.05, 0.5)

    def shown(size: float) -> FloatArray:
        forces, knee = felt.forces.copy(), top * (1.0 - size)
        forces[:, channels] = knee + width * curve((forces[:, channels] - knee) / width)
        return forces

    return Law(0.9, shown)


def hysteresis(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Play operators of a drawn density (Prandtl-Ishlinskii). Size: half the loop over the range.

    p_r(t) = min(max(p_r(t-), f - r), f + r); shown is f + sum_r w_r (p_r - f).
    """
    top = _top(felt, channels)
    radii = top * np.geomspace(0.01, rng.uniform(0.1, 0.6), OPERATORS)
    weights = density(np.log(radii), rng)
    forces = felt.forces[:, channels, None]
    states = np.empty((*forces.shape[:2], OPERATORS))
    state = np.zeros(states.shape[1:])
    for part in felt.runs:
        state = np.clip(state, -radii, radii)  # the shoe is lifted in between
        for index in range(part.start, part.stop):
            state = np.clip(state, forces[index] - radii, forces[index] + radii)
            states[index] = state
    width = float(weights @ radii) / top
    return added(felt, channels, (states - forces) @ weights / width, width)


def creep(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Several exponentials, of other times in recovery. Size: final creep over load."""
    count = int(rng.integers(3, 7))
    times = np.exp(rng.uniform(np.log(1.0), np.log(200.0), count))
    weights = rng.dirichlet(np.ones(count))
    recovery = np.exp(rng.uniform(np.log(0.4), np.log(2.5), count))
    steps = np.diff(felt.time, prepend=felt.time[0])
    forces = felt.forces[:, channels, None]
    crept = np.zeros((len(steps), len(channels)))
    state = np.zeros((len(channels), count))
    for index, step in enumerate(steps):
        short = forces[index] - state
        state = state + short * -np.expm1(-step / (times * np.where(short > 0.0, 1.0, recovery)))
        crept[index] = state @ weights
    return added(felt, channels, crept, 0.5)


def _course(felt: Felt, rng: Generator) -> FloatArray:
    """(T,) integral of a band-limited random rate; 0 at first, at most 1 away."""
    rate = Smooth.drawn(float(np.exp(rng.uniform(np.log(15.0), np.log(200.0)))), rng)
    come = rate.integral(felt.time) - rate.integral(felt.time[:1])
    return np.asarray(come / np.abs(come).max())


def zero_drift(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Size: farthest that a zero comes, over the largest load."""
    course = _top(felt, channels) * _course(felt, rng)
    return added(felt, channels, course[:, None] * rng.uniform(0.6, 1.4, len(channels)), 0.5)


def span_drift(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Size: farthest that a gain comes, over 1."""
    course = _course(felt, rng)[:, None] * rng.uniform(0.6, 1.4, len(channels))
    return added(felt, channels, felt.forces[:, channels] * course, 0.5)


def crosstalk(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """Of receiver and donor. Size: what the receiver shows of a donor's largest load."""
    top = _top(felt, channels[1:])
    load = felt.forces[:, channels[1:]] / top
    heard = rng.choice([-1.0, 1.0]) * 0.5 * top * (load + monotone(rng)(load))
    return added(felt, channels[:1], heard, 0.5)


def stuck_cell(felt: Felt, channels: IntArray, rng: Generator, onset: float = 0.0) -> Law:
    """From an onset [s] on it sticks, more and more. Size: share of its force that is stuck."""
    hold = np.interp(onset, felt.time, felt.forces[:, channels[0]])
    since = (felt.time - onset) / np.exp(rng.uniform(np.log(0.05), np.log(3.0)))
    stuck = np.clip(monotone(rng)(since), 0.0, 1.0)
    wandering = hold * (1.0 + 0.03 * Smooth.drawn(20.0, rng)(felt.time))
    return added(felt, channels, (stuck * (wandering - felt.forces[:, channels[0]]))[:, None], 1.0)


def _late(felt: Felt, channels: IntArray, lag: FloatArray) -> FloatArray:
    """(T, n) forces with channels as they were (T,) before [s]; a run begins at rest."""
    forces = felt.forces.copy()
    for part in felt.runs:
        at, since = felt.since[part] - lag[part], felt.since[part]
        for channel in channels:
            forces[part, channel] = np.interp(at, since, felt.forces[part, channel])
    return forces


def latency(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """A delay that wanders. Size: its mean [s]."""
    wander = Smooth.drawn(rng.uniform(5.0, 60.0), rng)(felt.time)
    factor = np.maximum(1.0 + rng.uniform(0.05, 0.4) * wander, 0.0)
    factor /= factor.mean()
    return Law(LONGEST_S, lambda size: _late(felt, channels, size * factor))


def low_pass(felt: Felt, channels: IntArray, rng: Generator) -> Law:
    """A filter of a drawn impulse response that is nowhere negative. Size: its mean delay [s]."""
    delays = (np.arange(OPERATORS) + 0.5) / OPERATORS
    weights = density(delays, rng) * np.exp(-rng.uniform(0.0, 6.0) * delays)
    weights /= weights.sum()
    delays /= float(weights @ delays)

    def shown(size: float) -> FloatArray:
        lags = size * delays[:, None] * np.ones(len(felt.time))
        late = [_late(felt, channels, lag) for lag in lags]
        return np.asarray(sum(weight * one for weight, one in zip(weights, late, strict=True)))

    return Law(LONGEST_S, shown)


Draw = Callable[[Felt, IntArray, Generator], Law]
LAWS: Mapping[str, Draw] = {
    "nonlinearity": nonlinearity, "saturation": saturation, "hysteresis": hysteresis,
    "creep": creep, "zero_drift": zero_drift, "span_drift": span_drift, "crosstalk": crosstalk,
    "stuck_cell": stuck_cell, "latency": latency, "low_pass": low_pass,
}  # fmt: skip
"""By effect: from what was felt, the channels of its place, and chance."""


def drawn_law(
    felt: Felt, effect: str, location: tuple[str, ...], seed: int, onset: float | None = None
) -> Law:
    """The law that a seed draws of an effect at a place.

    Args:
        onset: from which it acts, in the session's time [s]; None: always.
    """
    rng, channels = np.random.default_rng(seed), channels_of(felt, location)
    if onset is not None:
        return stuck_cell(felt, channels, rng, onset)
    return LAWS[effect](felt, channels, rng)


def channels_of(felt: Felt, location: tuple[str, ...]) -> IntArray:
    """Indices of the channels of cells, a foot, or all."""
    names = felt.shoe.names
    if location == ("all",):
        return np.arange(len(names))
    if location[0] in FEET:
        return np.asarray(felt.shoe.of_foot(FEET.index(location[0])))
    return np.array([names.index(name) for name in location])
