"""The temperature of the shoes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray


@dataclass(frozen=True)
class WarmUp:
    """Shoes warm up from the session's first instant on: electronics, and motors above them.

    T(t) = ambient + rise (1 - exp(-t / time))

    Attributes:
        ambient: [degC].
        rise: after a long time [K].
        time: time constant [s].
        measured: whether a device reports it.
    """

    ambient: float
    rise: float
    time: float
    measured: bool

    def above_ambient(self, time: float) -> float:
        """By how much they are warmer than at the session's first instant [K]."""
        return self.rise * -math.expm1(-max(time, 0.0) / self.time)

    def reading(self, time: FloatArray) -> FloatArray:
        """(...) what the device reports at session times (...) [s]: [degC], else NaN."""
        temperature = self.ambient - self.rise * np.expm1(-time / self.time)
        return temperature if self.measured else np.full(np.shape(time), np.nan)
