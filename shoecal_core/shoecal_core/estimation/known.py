"""What is known of a shoe before the robot moves, as rows of the joint fit.

By a manual calibration: gains and offsets, and where each foot's CoP is for loads on it; the last
says where cells and plates truly carry. How far they may have changed since is a hypothesis
(`Since`): the first that the data do not contradict holds.

By a robot that hangs: in the air each foot's force and moments are zero whatever the model says;
its channels carry the parts below them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from scipy.linalg import solve_triangular

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    by_parameters,
    cop,
    cop_jacobian,
    foot_wrenches,
)

GAIN_DRIFT = 0.005
"""How far gains may have moved since, as a share of them; cells' data sheets state less a year."""
STEADY_SHARE, STEADY_ZERO_N = 0.0002, 0.003
"""The same of gains and zeros of shoes that are as they were: less than weights on them show."""


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
    foot: IntArray
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


@dataclass(frozen=True)
class KnownZeros:
    """Feet in the air: m conditions on gains and offsets of n channels.

    Attributes:
        columns: (m, n) how an output enters the force or the moment that is zero [1 or m].
        readings: (m, n) in the air.
        below: (m,) what the parts below the channels add [N or N m].
        std: (m,) standard deviations [N or N m].
    """

    columns: FloatArray
    readings: FloatArray
    below: FloatArray
    std: FloatArray

    def rows(self, parameters: ChannelParameters) -> tuple[FloatArray, FloatArray]:
        """Rows of the joint fit, whitened: (m, 2n) by what gains and offsets are too large by, and
        their targets (m,).
        """
        by_offset = self.columns / self.std[:, None]
        shown = np.sum(self.columns * parameters.outputs(self.readings), axis=1) + self.below
        return by_parameters(by_offset[:, None], self.readings)[:, 0], shown / self.std
