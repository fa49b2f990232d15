"""What is believed of gains and offsets before any sample: for fits, plans and diagnoses alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.settings import Settings, setting
from shoecal_core.shoe.shoe import Shoe

USUAL_WEIGHT = 52.0
"""N, of a small humanoid; what is in newtons grows with a robot that is heavier."""
TORQUE_LEVER_M = 0.1
"""A torque, its offset and the drift of it are expected as large as a force's at this lever."""


@dataclass(frozen=True)
class PriorSettings(Settings):
    """How far gains and offsets are off their initial guess, and for how long errors stay alike."""

    correlation_s: float = setting(
        2.0, "s", "for how long errors of the model stay alike", minimum=1e-3
    )
    gain_std: float = setting(
        1.0, "", "how far gains are off their initial guess, as a share of it", minimum=1e-6
    )
    nominal_gain_std: float = setting(
        0.1, "", "the same for channels whose data sheet gives a gain", minimum=1e-6
    )
    offset_std_n: float = setting(
        30.0, "N", "how far offsets are off their initial guess; for a robot of up to 52 N, more "
        "for heavier ones", minimum=1e-6,
    )  # fmt: skip


def parameter_std(
    shoe: Shoe, gain: FloatArray, weight: float, settings: PriorSettings
) -> FloatArray:
    """(2n,) prior standard deviations of gains and offsets about the initial guess.

    Args:
        shoe: of n channels; one with a nominal gain is known better.
        gain: (n,) gains that the prior is about, each in its channel's unit; 1 for shares of them.
        weight: of the robot [N]; the offsets of a heavier one may be larger.
        settings: how far both may be off.
    """
    known = np.array([channel.nominal_gain is not None for channel in shoe.channels])
    gains = np.abs(gain) * np.where(known, settings.nominal_gain_std, settings.gain_std)
    offsets = np.full(len(known), settings.offset_std_n * max(1.0, weight / USUAL_WEIGHT))
    offsets[shoe.torque] *= TORQUE_LEVER_M
    return np.concatenate((gains, offsets))
