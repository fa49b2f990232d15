"""Moments at which something pushed the robot, or held it, or its gears struck.

The joints do not show it, the cells do: force that is not the weight, and a CoP that leaves the
modelled one for less than seconds. Slow differences are the model's own.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.filters import evenly
from shoecal_core.screening.blocks import BLOCK_S, in_blocks
from shoecal_core.screening.noise import spread
from shoecal_core.screening.settings import CalibrationSettings

FAST_MOTIONS = ("faster", "faster_reversed")
"""Almost twice the usual speed makes every gear strike where it turns: that is no fault."""
SMOOTHING_S = 0.05
SLOW_S = 2.0
"""What lasts longer is slow."""
FORCE_STDS, COP_STDS = 2.0, 1.0
"""Limits, in the settings' standard deviations."""
NOISE_STDS = 6.0


def disturbed(
    time: FloatArray, force: FloatArray, place: FloatArray, settings: CalibrationSettings
) -> BoolArray:
    """(T,) marked: disturbed samples.

    Args:
        time: (T,) [s].
        force: (T,) measured less expected force [N].
        place: (T, 2) measured less modelled CoP [m].
    """
    errors = np.concatenate((force[:, None] - np.median(force), place), axis=1)
    smooth = evenly(_without_slow, errors, time)
    trembling = spread(smooth)
    limits = (FORCE_STDS * settings.force_std_n, COP_STDS * settings.cop_std_m)
    off_force = np.abs(smooth[:, 0]) > max(limits[0], NOISE_STDS * trembling[0])
    off_place = np.linalg.norm(smooth[:, 1:], axis=1) > max(
        limits[1], NOISE_STDS * float(trembling[1:].max())
    )
    marked: BoolArray = off_force | off_place
    return marked


def _without_slow(errors: FloatArray, period: float) -> FloatArray:
    """(T, 3) errors of force and place smoothed; of the place without what is slow."""
    few = max(1, round(SMOOTHING_S / period))
    smooth = uniform_filter1d(errors, few, axis=0, mode="nearest")
    smooth[:, 1:] -= _slowly(errors[:, 1:], max(1, round(BLOCK_S / period)))
    return np.asarray(smooth)


def _slowly(values: FloatArray, size: int) -> FloatArray:
    """(T, k) running median of values (T, k), by blocks of some samples."""
    blocks = np.median(in_blocks(values, size), axis=1)
    if not len(blocks):
        return np.broadcast_to(np.median(values, axis=0), values.shape)
    several = 2 * max(1, round(SLOW_S / 2.0 / BLOCK_S)) + 1
    slow = median_filter(blocks, size=(several, 1), mode="nearest")
    middles = np.arange(len(blocks)) * size + (size - 1) / 2.0
    at = np.arange(len(values))
    return np.stack([np.interp(at, middles, column) for column in slow.T], axis=1)
