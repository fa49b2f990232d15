"""The zeros of the sensors of a robot that hangs, as rows for the joint fit.

In the air each foot's force and moments are zero whatever the model says; its channels carry the
parts below them. Zeros differ from run to run by what `Tolerances` says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.samples.zeros import Zero
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, by_parameters, weight_below

FloatArray = NDArray[np.float64]
EXACT = 1e-4
"""N, N m; of zeros that are the same in all runs."""


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


def known_zeros(shoe: Shoe, zeros: Sequence[Zero], tolerances: Tolerances) -> KnownZeros:
    """Force and both moments of each foot in the air.

    Args:
        shoe: with n channels.
        zeros: of runs in which both feet are in the air.
        tolerances: by which zeros differ from run to run.
    """
    count = len(shoe.names)
    run_zero = tolerances.run_zero_n * np.where(shoe.torque, TORQUE_LEVER_M, 1.0)
    columns, readings, below, std = [], [], [], []
    for zero in zeros:
        own = np.where((shoe.foot == zero.foot)[:, None], shoe.columns, 0.0).T
        felt = np.any(own != 0.0, axis=1)
        columns.append(own[felt])
        readings.append(np.tile(zero.reading, (int(felt.sum()), 1)))
        below.append(weight_below(shoe)[zero.foot][felt])
        std.append(np.maximum(np.sqrt((own[felt] ** 2) @ run_zero**2), EXACT))
    if not zeros:
        return KnownZeros(np.zeros((0, count)), np.zeros((0, count)), np.zeros(0), np.zeros(0))
    return KnownZeros(*(np.concatenate(part) for part in (columns, readings, below, std)))
