"""Gauss-Newton on normal equations, with a prior that keeps every direction fixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.residuals import Normal
from shoecal_core.errors import ShoecalError

FloatArray = NDArray[np.float64]
_DECREASE = 1e-4
_SMALLEST_STEP = 1e-8


@dataclass(frozen=True)
class Prior:
    """What is believed before any sample: the paper's regularising term.

    Attributes:
        mean: (p,) where the parameters are expected.
        std: (p,) how far they may be off; 0 holds a parameter fixed.
    """

    mean: FloatArray
    std: FloatArray


@dataclass(frozen=True)
class Fit:
    """A minimum, certified by its own gradient.

    Attributes:
        vector: (p,) the parameters.
        cost: sum of squares there, prior included.
        initial_cost: the same at the prior's mean.
        gradient_norm: largest derivative of the cost, in units of each parameter's std:
            zero at a minimum.
        covariance: (p, p) of the parameters, if the stated standard deviations hold.
        information: (p, p) Fisher information of the data alone.
        singular_values: (p',) of the data's whitened Jacobian over the free parameters, falling:
            above 1 the data say more than the prior.
        directions: (p', p) the parameter directions that belong to them.
        iterations: Gauss-Newton steps taken.
    """

    vector: FloatArray
    cost: float
    initial_cost: float
    gradient_norm: float
    covariance: FloatArray
    information: FloatArray
    singular_values: FloatArray
    directions: FloatArray
    iterations: int

    @property
    def rank(self) -> int:
        """Number of directions that the data, not the prior, have fixed."""
        return int(np.sum(self.singular_values > 1.0))


def minimise(
    evaluate: Callable[[FloatArray], Normal],
    prior: Prior,
    *,
    max_iterations: int,
    tolerance: float = 1e-10,
) -> Fit:
    """Minimise the data's sum of squares plus the prior's, from the prior's mean.

    Each step is halved until the cost falls; the prior makes every step well defined.

    Raises:
        ShoecalError: when it does not settle within `max_iterations`.
    """
    free = prior.std > 0.0
    scale = prior.std[free]

    def whole(z: FloatArray) -> tuple[float, FloatArray, FloatArray, FloatArray, FloatArray]:
        vector = prior.mean.copy()
        vector[free] += scale * z
        normal = evaluate(vector)
        data = normal.hessian[np.ix_(free, free)] * np.outer(scale, scale)
        gradient = normal.gradient[free] * scale + z
        return normal.cost + float(z @ z), gradient, data, vector, normal.hessian

    z = np.zeros(int(free.sum()))
    cost, gradient, data, vector, information = whole(z)
    initial_cost = cost
    iterations = 0
    while True:
        step = -np.linalg.solve(data + np.eye(len(z)), gradient)
        promised = -float(gradient @ step)
        if promised <= tolerance * (1.0 + cost):
            break
        if iterations == max_iterations:
            raise ShoecalError(
                f"the least squares did not settle within {max_iterations} iterations; "
                "raise 'max_iterations' or check the recording"
            )
        length = 1.0
        while True:
            attempt = whole(z + length * step)
            if attempt[0] <= cost - _DECREASE * length * promised:
                break
            length /= 2.0
            if length < _SMALLEST_STEP:
                raise ShoecalError(
                    "the least squares cannot lower its cost any more: the readings do not fit "
                    "the model at all; check the shoe file's cell positions and polarities"
                )
        z = z + length * step
        cost, gradient, data, vector, information = attempt
        iterations += 1
    values, vectors = np.linalg.eigh(data)
    order = np.argsort(values)[::-1]
    directions = np.zeros((len(z), len(free)))
    directions[:, free] = vectors.T[order] * scale
    covariance = np.zeros((len(free), len(free)))
    covariance[np.ix_(free, free)] = np.linalg.inv(data + np.eye(len(z))) * np.outer(scale, scale)
    return Fit(
        vector=vector,
        cost=cost,
        initial_cost=initial_cost,
        gradient_norm=float(np.abs(gradient).max(initial=0.0)),
        covariance=covariance,
        information=information,
        singular_values=np.sqrt(np.clip(values[order], 0.0, None)),
        directions=directions,
        iterations=iterations,
    )
