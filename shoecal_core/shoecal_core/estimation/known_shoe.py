"""What is known of a shoe by a manual calibration before the robot moves.

Its gains and offsets, and where each foot's CoP is for loads on it: the last says where cells and
plates truly carry. All are rows of the joint fit. How far they may have changed since is a
hypothesis (`Since`): the first that the data do not contradict holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.shoe.load_cases import single_support_outputs
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, cop_jacobian, foot_wrenches

FloatArray = NDArray[np.float64]

GAIN_DRIFT = 0.005
"""How far gains may have moved since, as a share of them; cells' data sheets state less a year."""
STEADY_SHARE, STEADY_ZERO_N = 0.0002, 0.003
"""The same of gains and zeros of shoes that are as they were: less than weights on them show."""
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


class Since(Enum):
    """What has become of shoes since they were calibrated; each contains the one before."""

    STEADY = "as they were"
    ZEROS = "other zeros"
    CHANGED = "other zeros and gains"


@dataclass(frozen=True)
class KnownShoe:
    """What is known of n channels of one shoe, or of both.

    Attributes:
        parameters: of the manual calibration.
        covariance: (2n, 2n) of its gains and offsets, as they were then.
        since: what may have become of them.
        outputs: (m, n) of the channels in m load cases [N or N m].
        foot: (m,) that is loaded in each.
        cop: (m, 2) where its CoP is, in the foot's sole frame [m].
        std: of each coordinate, as if every case erred by itself [m].
        zero_drift: how far zeros may have moved since, where they have [N].
    """

    parameters: ChannelParameters
    covariance: FloatArray
    outputs: FloatArray
    foot: NDArray[np.int64]
    cop: FloatArray
    std: float
    zero_drift: float
    since: Since = Since.CHANGED

    @property
    def now(self) -> FloatArray:
        """(2n, 2n) covariance of gains and offsets by now."""
        gain = np.abs(self.parameters.gain)
        share = GAIN_DRIFT if self.since is Since.CHANGED else STEADY_SHARE
        zero = STEADY_ZERO_N if self.since is Since.STEADY else self.zero_drift
        drift = np.concatenate((share * gain, np.full(len(gain), zero)))
        covariance: FloatArray = self.covariance + np.diag(drift**2)
        return covariance

    def under(self, since: Since) -> KnownShoe:
        """The same under another hypothesis."""
        return replace(self, since=since)

    def rows(
        self, shoe: Shoe, parameters: ChannelParameters, deviations: Sequence[Deviation]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rows of the joint fit, whitened: (r, 2n) by what gains and offsets are too large by,
        (r, k) by deviations, and their targets (r,).
        """
        count, size = len(self.covariance), len(deviations)
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
        factor = np.linalg.cholesky(self.now)
        whiten = solve_triangular(factor, np.eye(count), lower=True)
        off = np.concatenate(
            (
                parameters.gain - self.parameters.gain,
                parameters.offset - self.parameters.offset,
            )
        )
        by_parameters = np.concatenate((whiten, np.zeros((slopes.shape[0] * 2, count))))
        by_deviation = np.concatenate(
            (np.zeros((count, size)), slopes.reshape(-1, size) / self.std)
        )
        target = np.concatenate((whiten @ off, (self.cop - places).reshape(-1) / self.std))
        return by_parameters, by_deviation, target


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
