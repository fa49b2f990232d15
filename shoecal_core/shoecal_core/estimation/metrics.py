"""Errors of GRF and CoP as the paper counts them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray


@dataclass(frozen=True)
class Mae:
    """A mean absolute error.

    Attributes:
        mean, std: of the absolute error; NaN where nothing could be compared.
        count: samples compared.
        left_out: samples that could not be, since one side had no value: an unloaded foot.
    """

    mean: float
    std: float
    count: int
    left_out: int = 0


def grf_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of forces (T,) [N] (paper, eq. 7); what is not finite is left out and counted."""
    return _mae(np.abs(measured - reference))


def cop_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of CoPs (T, 2) [m]: mean Euclidean norm (paper, eq. 8); NaN is left out and counted."""
    return _mae(np.linalg.norm(measured - reference, axis=-1))


def _mae(error: FloatArray) -> Mae:
    finite = error[np.isfinite(error)]
    left_out = len(error) - len(finite)
    if not len(finite):
        return Mae(float("nan"), float("nan"), 0, left_out)
    return Mae(float(finite.mean()), float(finite.std()), len(finite), left_out)
