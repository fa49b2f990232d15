"""The one linear solver with priors: what fits, screens and diagnoses share.

Of unknowns x ~ N(0, 1 / precision) and whitened rows y = A x + e, e ~ N(0, 1), the posterior is
N(m, C) with C = (A'A + diag(precision))^-1 and m = C A'y. Everything follows from one Cholesky
factor of the equations scaled to a unit diagonal.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from shoecal_core.arrays import FloatArray

ROUNDING = 1e-13
"""Added to the unit diagonal: columns that are alike to the last digit stay solvable."""


class Posterior:
    """The posterior of p unknowns.

    Args:
        normal: (p, p) A'A. precision: (p,) of the priors. All in any units.

    Raises:
        numpy.linalg.LinAlgError: when the equations are not finite, or no sum of squares.
    """

    def __init__(self, normal: FloatArray, precision: FloatArray) -> None:
        self.precision = precision
        self._scale = 1.0 / np.sqrt(np.diag(normal) + precision)
        system = (normal + np.diag(precision)) * np.outer(self._scale, self._scale)
        if not np.isfinite(system).all():
            raise np.linalg.LinAlgError("equations that are not finite")
        self._factor = np.linalg.cholesky(system + ROUNDING * np.eye(len(system)))

    def whiten(self, right: FloatArray) -> FloatArray:
        """(p, m) H A'V of right sides A'V (p, m), with H'H = C: its squares are what V loses."""
        if not right.size:
            return np.zeros_like(right)
        whitened: FloatArray = solve_triangular(
            self._factor, (self._scale * right.T).T, lower=True, check_finite=False
        )
        return whitened

    def unwhiten(self, whitened: FloatArray) -> FloatArray:
        """(p,) or (p, m) solutions of right sides that are whitened."""
        if not whitened.size:
            return np.zeros_like(whitened)
        turned = solve_triangular(self._factor.T, whitened, lower=False, check_finite=False)
        solution: FloatArray = (self._scale * turned.T).T
        return solution

    def solve(self, right: FloatArray) -> FloatArray:
        """(p,) or (p, m) C times right sides."""
        return self.unwhiten(self.whiten(right))

    @property
    def root(self) -> FloatArray:
        """(p, p) H', a square root of C."""
        return self.whiten(np.eye(len(self.precision))).T

    @cached_property
    def covariance(self) -> FloatArray:
        """(p, p) C."""
        root = self.root
        covariance: FloatArray = root @ root.T
        return covariance

    @cached_property
    def variance(self) -> FloatArray:
        """(p,) diagonal of C."""
        variance: FloatArray = (self.root**2).sum(axis=1)
        return variance

    @cached_property
    def half_log_volume(self) -> float:
        """Half the logarithm of how many times smaller the posterior's volume is, squared."""
        ends = np.log(np.diag(self._factor)).sum() - np.log(self._scale).sum()
        return float(ends - 0.5 * np.log(self.precision).sum())
