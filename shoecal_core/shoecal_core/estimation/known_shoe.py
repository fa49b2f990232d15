"""What is known of a shoe by a manual calibration before the robot moves.

Its gains, and where each foot's CoP is for loads on it: the second says where cells and plates
truly carry, in the form of rows for the joint fit. Offsets drift, and are not taken from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.shoe.load_cases import single_support_outputs
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, cop_jacobian, foot_wrenches

FloatArray = NDArray[np.float64]

GAIN_DRIFT = 0.005
"""How far gains may have moved since, as a share of them."""
COP_STD_M = 0.001
"""How far the corrected CoP of a manual calibration is off (paper, table I)."""
PLACES = 4
"""Along each axis of the range of places that were loaded, for which the CoP is taken."""
FORCE_SHARES = (0.3, 0.5, 0.7)
"""Loads, over the robot's weight."""
INDEPENDENT = 8.0
"""Of these cases so many err by themselves: a hole's error is the same under each weight."""


@dataclass(frozen=True)
class KnownShoe:
    """What is known of n channels of one shoe, or of both.

    Attributes:
        gain, gain_std: (n,) of the manual calibration.
        outputs: (m, n) of the channels in m load cases [N or N m].
        foot: (m,) that is loaded in each.
        cop: (m, 2) where its CoP is, in the foot's sole frame [m].
        std: of each coordinate, as if every case erred by itself [m].
    """

    gain: FloatArray
    gain_std: FloatArray
    outputs: FloatArray
    foot: NDArray[np.int64]
    cop: FloatArray
    std: float

    def rows(
        self, shoe: Shoe, parameters: ChannelParameters, deviations: Sequence[Deviation]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rows of the joint fit, whitened: (r, n) by what gains are too large by, (r, k) by
        deviations, and their targets (r,).
        """
        count, size = len(self.gain), len(deviations)
        places, slopes = np.zeros_like(self.cop), np.zeros((len(self.foot), 2, size))
        for foot in np.unique(self.foot):
            here = self.foot == foot
            wrench = foot_wrenches(shoe, self.outputs[here])[:, foot]
            places[here] = cop(wrench, 0.0)
            by_wrench = cop_jacobian(wrench)[:, 1:]
            own = (shoe.foot == foot)[:, None]
            for index, one in enumerate(deviations):
                if one.shoe_column is not None:
                    moved = self.outputs[here] @ np.where(own, one.shoe_column, 0.0)
                    slopes[here, :, index] = (by_wrench @ moved[:, :, None])[..., 0]
        by_gain = np.concatenate(
            (np.diag(1.0 / self.gain_std), np.zeros((slopes.shape[0] * 2, count)))
        )
        by_deviation = np.concatenate(
            (np.zeros((count, size)), slopes.reshape(-1, size) / self.std)
        )
        target = np.concatenate(
            (
                (parameters.gain - self.gain) / self.gain_std,
                (self.cop - places).reshape(-1) / self.std,
            )
        )
        return by_gain, by_deviation, target


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
    own = np.zeros(count) if covariance is None else np.sqrt(np.diag(covariance)[:count])
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
        gain=parameters.gain,
        gain_std=np.hypot(own, GAIN_DRIFT * np.abs(parameters.gain)),
        outputs=loads,
        foot=foot,
        cop=measured[np.arange(len(foot)), foot],
        std=COP_STD_M * float(np.sqrt(per_foot / INDEPENDENT)),
    )
