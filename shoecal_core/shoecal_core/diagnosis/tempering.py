"""How much a logarithm of evidence counts: hypotheses are only models of what reality does."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.settings import DiagnosisSettings

FORM_ERROR = 0.04
"""A cause whose form the library has only nearly is this share of the evidence off."""


def temper(best: float) -> float:
    """The share of it that counts where the best explanation has this much."""
    return 1.0 / (1.0 + FORM_ERROR * max(best, 0.0))


def needed(settings: DiagnosisSettings) -> float:
    """Logarithm of evidence from which a robot within tolerance is improbable enough."""
    return math.log((1.0 - settings.false_alarms) / settings.false_alarms)


def shares(logs: FloatArray | Sequence[float]) -> FloatArray:
    """(k,) probabilities from their logarithms (k,), all of them off by the same constant."""
    found = np.exp(np.asarray(logs) - np.max(logs))
    total: FloatArray = found / found.sum()
    return total
