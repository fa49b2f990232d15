"""How channels add to the wrench on the soles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.wrench import to_left


@dataclass(frozen=True)
class Wiring:
    """How channels add to the wrench: the shoe file's word, unless a cable says otherwise.

    Attributes:
        columns: (n, 3) of each channel in its own foot's sole frame.
        foot: (n,) that each channel acts on.
    """

    columns: FloatArray
    foot: IntArray

    def of_foot(self, foot: int) -> FloatArray:
        """(n, 3) in that foot's sole frame; those of the other foot zero."""
        return np.where((self.foot == foot)[:, None], self.columns, 0.0)

    def in_left(self, support: DoubleSupport) -> FloatArray:
        """(n, 3) of both feet in the left sole's frame."""
        columns = self.columns.copy()
        right = self.foot == 1
        columns[right] = columns[right] @ to_left(support).T
        return columns
