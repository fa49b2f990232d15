"""Quadratic programs whose active rows are nearly known.

From one program of a horizon to the next hardly a row becomes active or ceases to be. So the
rows that were active are taken as equations, and exchanged by the signs of slacks and multipliers
until those are right (Hintermüller, Ito and Kunisch, "The primal-dual active set strategy as a
semismooth Newton method", 2002): mostly one or two small linear systems. That need not end, so
exchanges are bounded, and another method steps in.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from shoecal_core.arrays import FloatArray

_EXCHANGES = 6


def active_set_solution(
    hessian: FloatArray,
    gradient: FloatArray,
    matrix: FloatArray,
    low: FloatArray,
    high: FloatArray,
    active: FloatArray,
    tolerance: float,
) -> tuple[FloatArray, FloatArray] | None:
    """Minimise x H x / 2 + g x subject to low <= x A <= high.

    Args:
        hessian: (n, n) positive definite.
        gradient: (n,).
        matrix: (n, m) A, a column for each row of the program.
        low, high: (m,), infinite where there is no bound.
        active: (m,) 1 where a row is thought to be at its upper bound, -1 at its lower, else 0.
        tolerance: largest violation of a row.

    Returns:
        (n,) solution and (m,) multipliers, positive at upper bounds; None where exchanges do not
        settle.
    """
    # LAPACK itself: the systems are so small that scipy's checks would take most of the time.
    factor, failed = dpotrf(hessian, lower=1)
    if failed:
        return None
    free = dpotrs(factor, -gradient, lower=1)[0]
    for _ in range(_EXCHANGES):
        rows = np.flatnonzero(active)
        if len(rows) > len(gradient):
            return None
        signs = active[rows]
        prices, found = np.zeros(len(rows)), free
        if len(rows):
            normals = matrix[:, rows]
            ways = dpotrs(factor, normals, lower=1)[0]
            beyond = free @ normals - np.where(signs > 0.0, high[rows], low[rows])
            small, failed = dpotrf(normals.T @ ways, lower=1)
            # Rows that depend on each other.
            if failed:
                return None
            prices = dpotrs(small, beyond, lower=1)[0]
            found = free - ways @ prices
        reached = found @ matrix
        better = (reached > high + tolerance).astype(np.float64)
        better -= reached < low - tolerance
        better[rows] = np.where(prices * signs > 0.0, signs, 0.0)
        if np.array_equal(better, active):
            multipliers = np.zeros(len(active))
            multipliers[rows] = prices
            return found, multipliers
        active = better
    return None
