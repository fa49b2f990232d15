"""A robot that is lifted for a while within a run: both feet hang, and read their zeros.

Looked for before what else readings show, since channels that rest at their zeros look saturated.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shoecal_core.arrays import BoolArray
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.contact import moves
from shoecal_core.samples.lifting import TRANSIT_S
from shoecal_core.samples.stretches import lasting, unchanged, widened
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import at_least_load, both_carry_load
from shoecal_core.shoe.wrench import foot_wrenches

HANGS_SHARE = 0.1
"""Of the weight: by gains and offsets that are roughly known, a foot that hangs carries less."""
LEAST_S = 1.0
"""A robot that is lifted for a shorter time does not hang still."""
SETTLE_S = 0.15
"""Cut from both ends of that time: there the feet are just leaving or landing."""
LEAST_STANDING = 0.2
"""Of a run, that has to be left for it to be one in double support."""


def both_hang(
    aligned: Mapping[int, Aligned], shoe: Shoe, weight: float, settings: CalibrationSettings
) -> dict[int, BoolArray]:
    """(T,) of each run in which the whole robot is lifted for a while: both feet hang still.

    Args:
        aligned: runs in double support, by number.
        weight: of robot and shoes [N].
    """
    low = {run: _both_low(shoe, one) for run, one in aligned.items()}
    low = {run: one for run, one in low.items() if one.any()}
    if not low:
        return {}
    # Gains and offsets by all else: no model holds for a robot that is carried.
    parts = {run: blocks(without(one, low.get(run)), shoe) for run, one in aligned.items()}
    parameters = Statics.of(shoe, parts, weight, settings).fit.parameters
    found = {}
    for run, mask in low.items():
        outputs = parameters.outputs(aligned[run].readings[mask])
        carried = np.median(foot_wrenches(shoe, outputs)[..., 0], axis=0)
        if (np.abs(carried) < HANGS_SHARE * weight).all():
            found[run] = mask
    return found


def without(aligned: Aligned, hanging: BoolArray | None) -> Aligned:
    """A run without the time (T,) in which the robot hangs, and is on its way there and back."""
    if hanging is None:
        return aligned
    return aligned.part(~widened(hanging, aligned.time, TRANSIT_S))


def _both_low(shoe: Shoe, aligned: Aligned) -> BoolArray:
    """(T,) both feet read their least, still, and for a while."""
    nowhere = np.zeros(len(aligned.time), dtype=bool)
    if both_carry_load(shoe, aligned.readings) is None:
        return nowhere
    low: BoolArray = np.all(at_least_load(shoe, aligned.readings), axis=1)
    low = ~widened(~low, aligned.time, SETTLE_S)
    low = lasting(low, aligned.time, LEAST_S)
    for part in unchanged(low.astype(np.int64)):
        if low[part[0]]:
            low[part] = not any(moves(shoe, aligned.readings, part, foot) for foot in (0, 1))
    return low if low.mean() <= 1.0 - LEAST_STANDING else nowhere
