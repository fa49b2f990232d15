"""Gauss-Newton on normal equations, with a prior that keeps every direction fixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

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
    cost: Callable[[FloatArray], float] | None = None,
    start: FloatArray | None = None,
) -> Fit:
    """Minimise the data's sum of squares plus the prior's.

    Each step is halved until the cost falls; the prior makes every step well defined.

    Args:
        evaluate: the data's sum of squares and its Gauss-Newton model.
        prior: added to it.
        max_iterations: steps after which to give up.
        tolerance: it ends where a step promises to lower the cost by less than this share.
        cost: the data's sum of squares alone, where that is cheaper to have.
        start: (p,) where to begin; the prior's mean by default.

    Raises:
        ShoecalError: when it does not settle within `max_iterations`.
    """
    problem = _Whitened(evaluate, cost or (lambda vector: evaluate(vector).cost), prior)
    mean = np.zeros(int(problem.free.sum()))
    point = problem.point(mean if start is None else problem.whitened(start))
    initial_cost = point.cost if start is None else problem.cost(mean)
    for iterations in count():
        step = point.step()
        promised = -float(point.gradient @ step)
        if promised <= tolerance * (1.0 + point.cost):
            return _certified(point, problem, initial_cost, iterations)
        if iterations == max_iterations:
            break
        point = _lower(problem, point, step, promised)
    raise ShoecalError(
        f"the least squares did not settle within {max_iterations} iterations; "
        "raise 'max_iterations' or check the recording"
    )


@dataclass(frozen=True)
class _Point:
    """The whole cost and its Gauss-Newton model at one whitened vector z.

    Attributes:
        z: (p',) free parameters, less the prior's mean, in units of its std.
        vector: (p,) all parameters.
        cost: sum of squares, prior included.
        gradient: (p',) half its derivative by z.
        data: (p', p') Gauss-Newton matrix of the data alone, by z.
        information: (p, p) the same by the parameters.
    """

    z: FloatArray
    vector: FloatArray
    cost: float
    gradient: FloatArray
    data: FloatArray
    information: FloatArray

    def step(self) -> FloatArray:
        """(p',) to the minimum of the model."""
        descent = np.linalg.solve(self.data + np.eye(len(self.z)), -self.gradient)
        return np.asarray(descent, dtype=np.float64)


class _Whitened:
    """The sum of squares over the free parameters, each in units of its prior."""

    def __init__(
        self,
        evaluate: Callable[[FloatArray], Normal],
        cost: Callable[[FloatArray], float],
        prior: Prior,
    ) -> None:
        self._evaluate = evaluate
        self._cost = cost
        self._mean = prior.mean
        self.free = prior.std > 0.0
        self.scale = prior.std[self.free]

    def whitened(self, vector: FloatArray) -> FloatArray:
        z: FloatArray = (vector - self._mean)[self.free] / self.scale
        return z

    def cost(self, z: FloatArray) -> float:
        return self._cost(self._vector(z)) + float(z @ z)

    def point(self, z: FloatArray) -> _Point:
        vector = self._vector(z)
        normal = self._evaluate(vector)
        return _Point(
            z=z,
            vector=vector,
            cost=normal.cost + float(z @ z),
            gradient=normal.gradient[self.free] * self.scale + z,
            data=normal.hessian[np.ix_(self.free, self.free)] * np.outer(self.scale, self.scale),
            information=normal.hessian,
        )

    def _vector(self, z: FloatArray) -> FloatArray:
        vector = self._mean.copy()
        vector[self.free] += self.scale * z
        return vector


def _lower(problem: _Whitened, point: _Point, step: FloatArray, promised: float) -> _Point:
    """The point after a step, halved until the cost falls enough."""
    ahead = problem.point(point.z + step)  # the whole step is good enough nearly always
    length = 1.0
    cost = ahead.cost
    while not cost <= point.cost - _DECREASE * length * promised:
        length /= 2.0
        if length < _SMALLEST_STEP:
            raise ShoecalError(
                "the least squares cannot lower its cost any more: the readings do not fit "
                "the model at all; check the shoe file's cell positions and polarities"
            )
        cost = problem.cost(point.z + length * step)
    return ahead if length == 1.0 else problem.point(point.z + length * step)


def _certified(point: _Point, problem: _Whitened, initial_cost: float, iterations: int) -> Fit:
    free, scale = problem.free, problem.scale
    values, vectors = np.linalg.eigh(point.data)
    order = np.argsort(values)[::-1]
    directions = np.zeros((len(scale), len(free)))
    directions[:, free] = vectors.T[order] * scale
    covariance = np.zeros((len(free), len(free)))
    inverse = np.linalg.inv(point.data + np.eye(len(scale)))
    covariance[np.ix_(free, free)] = inverse * np.outer(scale, scale)
    return Fit(
        vector=point.vector,
        cost=point.cost,
        initial_cost=initial_cost,
        gradient_norm=float(np.abs(point.gradient).max(initial=0.0)),
        covariance=covariance,
        information=point.information,
        singular_values=np.sqrt(np.clip(values[order], 0.0, None)),
        directions=directions,
        iterations=iterations,
    )
