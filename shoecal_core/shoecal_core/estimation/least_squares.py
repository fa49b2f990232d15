"""Nonlinear least squares by scipy, with a prior that keeps every direction fixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.errors import ShoecalError

Rows = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Residuals (k,) of a vector (p,), and their Jacobian (k, p)."""

MAX_EVALUATIONS = 100
_PRECISION = 1e-12
"""Share by which cost or vector change where the steps end."""


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
        iterations: evaluations of the residuals.
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


def minimise(rows: Rows, prior: Prior, max_evaluations: int = MAX_EVALUATIONS) -> Fit:
    """Minimise the rows' sum of squares plus the prior's, from the prior's mean.

    Raises:
        ShoecalError: when it does not settle.
    """
    free = prior.std > 0.0
    scale = prior.std[free]

    def vector_of(z: FloatArray) -> FloatArray:
        """All parameters of the free ones, which are in units of the prior."""
        vector = prior.mean.copy()
        vector[free] += scale * z
        return vector

    def errors(z: FloatArray) -> FloatArray:
        return np.concatenate((rows(vector_of(z))[0], z))

    def slopes(z: FloatArray) -> FloatArray:
        return np.vstack((rows(vector_of(z))[1][:, free] * scale, np.eye(len(z))))

    start = np.zeros(len(scale))
    initial = errors(start)
    if not np.isfinite(initial).all():
        raise _misfit()
    found = least_squares(
        errors, start, slopes, method="lm", max_nfev=max_evaluations,
        ftol=_PRECISION, xtol=_PRECISION, gtol=_PRECISION,
    )  # fmt: skip
    if not np.isfinite(found.cost):
        raise _misfit()
    if not found.success:
        raise ShoecalError(
            f"the least squares did not settle within {max_evaluations} evaluations; check "
            "polarities and cell positions in the shoe file"
        )
    vector = vector_of(found.x)
    whole = rows(vector)[1]
    data = whole[:, free] * scale
    values, vectors = np.linalg.eigh(data.T @ data)
    order = np.argsort(values)[::-1]
    directions = np.zeros((len(scale), len(free)))
    directions[:, free] = vectors.T[order] * scale
    covariance = np.zeros((len(free), len(free)))
    kept = whole[:, free]
    covariance[np.ix_(free, free)] = Posterior(kept.T @ kept, scale**-2.0).covariance
    std = np.sqrt(np.diag(covariance)[free]) / scale
    return Fit(
        vector=vector,
        cost=2.0 * float(found.cost),
        initial_cost=float(initial @ initial),
        gradient_norm=float(np.abs(2.0 * std * found.grad).max(initial=0.0)),
        covariance=covariance,
        information=whole.T @ whole,
        singular_values=np.sqrt(np.clip(values[order], 0.0, None)),
        directions=directions,
        iterations=int(found.nfev),
    )


def _misfit() -> ShoecalError:
    return ShoecalError(
        "the readings do not fit the model at all; check the shoe file's cell positions and "
        "polarities"
    )
