"""How much a logarithm of evidence counts: hypotheses are only models of what reality does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.settings import DiagnosisSettings

FloatArray = NDArray[np.float64]


def temper(best: float, settings: DiagnosisSettings) -> float:
    """The share of it that counts where the best explanation has this much."""
    return 1.0 / (1.0 / settings.temper + settings.form_error * max(best, 0.0))


def shares(logs: FloatArray | Sequence[float]) -> FloatArray:
    """Probabilities of what has these logarithms of them, but for a constant."""
    found = np.exp(np.asarray(logs) - np.max(logs))
    total: FloatArray = found / found.sum()
    return total
