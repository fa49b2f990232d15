"""Runs that lift one foot on purpose: when it hangs free, and when it is on its way.

A foot in the air carries nothing, which fixes its offsets, and the other one carries the whole
weight alone. So such a run is cut into stances: before, in the air, and after, when the foot may
stand a little elsewhere. What lies between counts for nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.sampling import TRANSIT_S
from shoecal_core.screening.closure import lifted
from shoecal_core.screening.stretches import lasting, widened

BoolArray = NDArray[np.bool_]

UNLOADING: Mapping[str, int] = {"unload_left": 0, "unload_right": 1}
"""Motions that lift a foot, by name: index of the foot."""
FREE_SHARE = 0.6
"""A foot hangs free above this share of the height that it is lifted to: gears that give make
that height a little less than it seems."""
LEAST_AIR_S = 0.5
"""A foot that is up for a shorter time does not hang still."""


@dataclass(frozen=True)
class LiftedFoot:
    """A run in which one foot is lifted.

    Attributes:
        foot: index of it.
        air: (T,) it hangs free.
        moving: (T,) it is neither free nor firmly on the floor.
    """

    foot: int
    air: BoolArray
    moving: BoolArray

    def stretches(self) -> list[BoolArray]:
        """(T,) masks of each part between changes of what carries, `moving` left out."""
        changes = np.flatnonzero(np.diff(self.air.astype(np.int8)) != 0) + 1
        edges = [0, *changes.tolist(), len(self.air)]
        parts = []
        for first, end in pairwise(edges):
            mask = np.zeros(len(self.air), dtype=bool)
            mask[first:end] = ~self.moving[first:end]
            parts.append(mask)
        return parts


def detect_lifted_foot(motion: str, aligned: Aligned) -> LiftedFoot | None:
    """When the foot that a motion lifts is in the air; None where it lifts none.

    Args:
        motion: name on the catalogue of motions.
        aligned: T samples of the run.
    """
    if motion not in UNLOADING:
        return None
    time = aligned.time
    up = lifted(aligned.states)
    height = aligned.states.translation[:, 2]
    height = np.abs(height - np.median(height[~up])) if not up.all() else height
    high = up & (height > FREE_SHARE * height.max())
    inner = ~widened(~high, time, TRANSIT_S)
    air = lasting(inner, time, LEAST_AIR_S)
    return LiftedFoot(UNLOADING[motion], air, widened(up, time, TRANSIT_S) & ~air)
