"""Random functions: what the laws of a set are drawn from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from shoecal_core.arrays import FloatArray

Curve = Callable[[FloatArray], FloatArray]

FEATURES = 48
"""Waves that a smooth random function is made of."""


@dataclass(frozen=True)
class Smooth:
    """A smooth random function of d variables, of mean 0 and variance 1.

    y(x) = sqrt(2 / K) sum_k cos(w_k x + p_k): a Gaussian process whose spectrum is that of the
    drawn w_k, normal with a standard deviation of one over the correlation length.

    Attributes:
        waves: (K, d) w_k, in radians a unit of x.
        phases: (K,) p_k [rad].
    """

    waves: FloatArray
    phases: FloatArray

    @classmethod
    def drawn(cls, length: float, rng: np.random.Generator, variables: int = 1) -> Smooth:
        """One that changes over a correlation length, in the unit of x."""
        waves = rng.standard_normal((FEATURES, variables)) / length
        return cls(waves, rng.uniform(0.0, 2.0 * np.pi, FEATURES))

    def __call__(self, x: FloatArray) -> FloatArray:
        """(T,) values at x (T,) or (T, d)."""
        angles = x.reshape(len(x), -1) @ self.waves.T + self.phases
        return np.asarray(np.sqrt(2.0 / FEATURES) * np.cos(angles).sum(axis=1))

    def integral(self, x: FloatArray) -> FloatArray:
        """(T,) integral from 0 to x (T,), of one variable."""
        angles = x[:, None] * self.waves[:, 0] + self.phases
        grown = (np.sin(angles) - np.sin(self.phases)) / self.waves[:, 0]
        return np.asarray(np.sqrt(2.0 / FEATURES) * grown.sum(axis=1))


def monotone(rng: np.random.Generator) -> Curve:
    """A smooth curve that rises from (0, 0) to (1, 1) by drawn steps, and is x itself outside."""
    steps = rng.gamma(rng.uniform(0.5, 2.0), size=int(rng.integers(3, 8)))
    heights = np.concatenate(([0.0], np.cumsum(steps) / steps.sum()))
    spline = PchipInterpolator(np.linspace(0.0, 1.0, len(heights)), heights)
    return lambda x: np.where((x > 0.0) & (x < 1.0), spline(np.clip(x, 0.0, 1.0)), x)


def bending(rng: np.random.Generator) -> Curve:
    """A curve that is x up to 0, bends over by drawn falling slopes, and is flat from 1 on."""
    falls = rng.gamma(0.7, size=int(rng.integers(2, 6)))
    slopes = 1.0 - np.concatenate(([0.0], np.cumsum(falls) / falls.sum()))
    spline = PchipInterpolator(np.linspace(0.0, 1.0, len(slopes)), slopes).antiderivative()
    return lambda x: np.minimum(x, 0.0) + spline(np.clip(x, 0.0, 1.0))


def density(nodes: FloatArray, rng: np.random.Generator) -> FloatArray:
    """(K,) positive random weights that change smoothly over nodes (K,); their sum is 1."""
    weights = np.exp(Smooth.drawn(0.35 * float(np.ptp(nodes)), rng)(nodes))
    return np.asarray(weights / weights.sum())
