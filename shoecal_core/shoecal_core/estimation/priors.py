"""What is believed of gains and offsets before any sample is fitted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.base import USUAL_WEIGHT
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
TORQUE_LEVER_M = 0.1
"""A torque's offset is expected as large as a force's offset at this lever."""


def parameter_std(
    shoe: Shoe, guess: ChannelParameters, weight: float, settings: SignalSettings
) -> FloatArray:
    """(2n,) prior standard deviations of gains and offsets about the guess.

    Args:
        shoe: of n channels; one with a nominal gain is known better.
        guess: gains and offsets that the prior is about.
        weight: of the robot [N]; the offsets of a heavier one may be larger.
        settings: how far both may be off.
    """
    known = np.array([channel.nominal_gain is not None for channel in shoe.channels])
    gain = np.abs(guess.gain) * np.where(known, settings.nominal_gain_std, settings.gain_std)
    offset = np.full(len(known), settings.offset_std_n * max(1.0, weight / USUAL_WEIGHT))
    offset[shoe.torque] *= TORQUE_LEVER_M
    return np.concatenate((gain, offset))
