"""Intervals of measured rates and medians."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import beta

from shoecal_core.arrays import FloatArray

Interval = tuple[float, float]

LEVEL = 0.95
_RESAMPLES = 2000


def clopper_pearson(count: int, total: int) -> Interval:
    """Exact interval of a rate."""
    tail = (1.0 - LEVEL) / 2.0
    lowest = 0.0 if count == 0 else float(beta.ppf(tail, count, total - count + 1))
    highest = 1.0 if count == total else float(beta.ppf(1.0 - tail, count + 1, total - count))
    return lowest, highest


def bootstrap(rows: ArrayLike, figure: Callable[[FloatArray], float]) -> Interval:
    """Interval of a figure of rows that are drawn again and again, always the same way."""
    values = np.asarray(rows, dtype=np.float64)
    rng = np.random.default_rng(0)
    found = [figure(values[rng.integers(len(values), size=len(values))]) for _ in range(_RESAMPLES)]
    low, high = np.quantile(found, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    return float(low), float(high)
