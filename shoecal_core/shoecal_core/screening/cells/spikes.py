"""Spikes: readings that jump away from their neighbours in time and come back at once.

A reading jumps when it is far from the median of the few around it. What hits the robot jumps in
several channels of a foot, in proportion; what jumps in one or two alone is in their cables or
converters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.shoe.shoe import Shoe

WIDTH = 9
"""Readings in the median: jumps of up to four of them stand out."""
NOISE_STDS, SURE_STDS = 8.0, 20.0
"""A jump is this far off in the channel's noise; one of which its companions would show, more."""
COMPANION_STDS, COMPANION_SHARE = 4.0, 0.1
"""A channel jumps along when it is this far off: in its own noise, and of the largest jump."""
ALONE = 1
"""Channels that jump together, at most, for it to be electrical."""


@dataclass(frozen=True)
class Jumps:
    """What jumps in the readings of a run.

    Attributes:
        spikes: (T, n) electrical ones.
        hits: (T,) times at which something hit the robot.
        calm: (T, n) readings with every jump replaced by the median around it.
    """

    spikes: BoolArray
    hits: BoolArray
    calm: FloatArray


def find_jumps(
    shoe: Shoe, readings: FloatArray, noise: FloatArray, gain: FloatArray, least: float
) -> Jumps:
    """Jumps of readings (T, n), and what is behind them.

    Args:
        noise: (n,) standard deviation of a reading.
        gain: (n,) of each channel, roughly.
        least: smaller jumps do no harm [N, and N m at a lever of 10 cm].
    """
    unit = np.where(shoe.torque, 0.1, 1.0)
    scale = np.abs(gain) / unit
    around = median_filter(readings, size=(WIDTH, 1), mode="nearest")
    off = np.abs(readings - around) * scale
    jumping = off > np.maximum(NOISE_STDS * noise * scale, least)
    spikes = np.zeros_like(jumping)
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        largest = off[:, own].max(axis=1, keepdims=True)
        along = off[:, own] > np.maximum(
            COMPANION_STDS * noise[own] * scale[own], COMPANION_SHARE * largest
        )
        alone = along.sum(axis=1, keepdims=True) <= ALONE
        sure = off[:, own] > SURE_STDS * (noise[own] * scale[own]).max()
        spikes[:, own] = jumping[:, own] & sure & alone
    hits: BoolArray = np.any(jumping & ~spikes, axis=1)
    return Jumps(spikes, hits, np.where(jumping, around, readings))
