"""Errors of GRF and CoP as the paper counts them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Mae:
    """A mean absolute error with the standard deviation of the absolute error."""

    mean: float
    std: float
    count: int


def grf_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of forces (T,) [N] (paper, eq. 7); samples that are not finite are left out."""
    return _mae(np.abs(measured - reference))


def cop_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of CoPs (T, 2) [m]: mean Euclidean norm (paper, eq. 8); NaN samples are left out."""
    return _mae(np.linalg.norm(measured - reference, axis=-1))


def _mae(error: FloatArray) -> Mae:
    finite = error[np.isfinite(error)]
    if not len(finite):
        return Mae(float("nan"), float("nan"), 0)
    return Mae(float(finite.mean()), float(finite.std()), len(finite))
