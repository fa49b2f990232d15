"""What a manual calibration says of a shoe, for the joint fit."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.known import KnownShoe
from shoecal_core.shoe.load_cases import single_support_outputs
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe

ZERO_DRIFT_SHARE = 0.1
"""How far zeros may have moved since, over the robot's weight: wide for what data show, and narrow
for the pattern (+ - - +) that they do not."""
COP_STD_M = 0.001
"""How far the corrected CoP of a manual calibration is off (paper, table I)."""
PLACES = 4
"""Along each axis of the range of places that were loaded, for which the CoP is taken."""
FORCE_SHARES = (0.3, 0.5, 0.7)
"""Loads, over the robot's weight."""
INDEPENDENT = 8.0
"""Of these cases so many err by themselves: a hole's error is the same under each weight."""


def known_shoe(
    shoe: Shoe, sensing: Sensing, covariance: FloatArray | None, weight: float
) -> KnownShoe:
    """What the measuring side of a manual calibration gives.

    Args:
        shoe: as its file says.
        sensing: of the manual calibration, corrections included.
        covariance: (2n, 2n) of its gains and offsets; None where it is not known.
        weight: of the robot [N].
    """
    parameters = sensing.parameters
    count = len(parameters.gain)
    outputs, feet = [], []
    for correction in sensing.corrections:
        low, high = correction.cop_range
        axes = [np.linspace(low[axis], high[axis], PLACES) for axis in (0, 1)]
        places = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        for share in FORCE_SHARES:
            outputs.append(single_support_outputs(shoe, correction.foot, share * weight, places))
            feet.append(np.full(len(places), correction.foot))
    loads = np.concatenate(outputs) if outputs else np.zeros((0, count))
    foot = np.concatenate(feet) if feet else np.zeros(0, dtype=np.int64)
    readings = (loads - parameters.offset) / parameters.gain
    measured = sensing.measure(readings).cop
    per_foot = max(1, len(foot) // max(1, len(sensing.corrections)))
    return KnownShoe(
        parameters=parameters,
        covariance=np.zeros((2 * count, 2 * count)) if covariance is None else covariance,
        outputs=loads,
        foot=foot,
        cop=measured[np.arange(len(foot)), foot],
        std=COP_STD_M * float(np.sqrt(per_foot / INDEPENDENT)),
        zero_drift=ZERO_DRIFT_SHARE * weight,
    )
