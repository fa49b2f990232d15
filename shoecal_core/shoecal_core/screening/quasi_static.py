"""Does the robot move slowly enough, by its joint angles?

A body that accelerates has its CoP not below its CoM but, as the zero-moment point, off by
z a / g: height of the CoM times horizontal acceleration over gravity.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import resampled, typical_period
from shoecal_core.samples.local_cubic import (
    SMOOTHING_S,
    acceleration_window,
    local_cubics,
    middle_weights,
)
from shoecal_core.screening.noise import spread
from shoecal_core.screening.settings import CalibrationSettings

LONGEST_GAP_S = 0.05
"""Near longer gaps in the recording accelerations are unknown."""
NOISE_STDS = 6.0
"""Of the accelerations that encoder steps alone make."""


def zmp_shift(aligned: Aligned) -> tuple[FloatArray, float]:
    """(T,) how far the zero-moment point is off the modelled CoP, and its noise [m]."""
    time = aligned.time
    period = typical_period(time)
    window = acceleration_window(period)
    com = aligned.states.com[:, 0]
    placed, even = resampled(com[:, :2], time)
    if len(even) < window:
        return np.zeros(len(time)), 0.0
    curved = local_cubics(placed, window, period, 2)
    size = np.linalg.norm(curved, axis=1)
    # At the ends the cubic is not held from both sides: what comes next to them is taken there.
    inner = slice(window // 2, len(even) - window // 2)
    fall = com[:, 2] / GRAVITY
    shift: FloatArray = fall * np.interp(time, even[inner], size[inner])
    for before in np.flatnonzero(np.diff(time) > LONGEST_GAP_S):
        gap = (time[before] - SMOOTHING_S / 2.0, time[before + 1] + SMOOTHING_S / 2.0)
        shift[(time >= gap[0]) & (time <= gap[1])] = 0.0
    # What the cubics leave. Second differences would not do: encoders step seldom in slow motion.
    left = spread(placed - local_cubics(placed, window, period))
    trembling = np.linalg.norm(middle_weights(window, period, 2))
    return shift, float(np.median(fall) * trembling * np.linalg.norm(left))


def too_fast(aligned: Aligned, settings: CalibrationSettings) -> BoolArray:
    """(T,) the acceleration shifts the CoP by more than the model's own error."""
    shift, trembling = zmp_shift(aligned)
    fast: BoolArray = shift > max(settings.cop_std_m, NOISE_STDS * trembling)
    return fast
