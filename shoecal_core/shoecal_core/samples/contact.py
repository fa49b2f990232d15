"""Which feet of a moving robot are in the air: joints and load have to agree.

By its readings alone no foot can be called unloaded, since the zero of a sensor is not known before
it hangs. So a foot is in the air where joints and base pose lift its whole sole off the floor, and
its sensor then reads what it reads whenever the foot is highest. A foot that carries a tenth of
the weight does neither.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import LOWEST_SHARE, polarity_known, vertical_forces

CLEARANCE_M = 0.005
"""A sole whose lowest corner is higher than this above the other's lowest one may be in the air."""
SURE_SHARE = 0.5
"""It surely is above this share of the height to which it is mostly lifted."""
LEAST_SURE = 5
"""Samples of that kind from which a zero is believed."""
NEAR_ZERO = 0.05
"""Force that a swinging foot feels, as a share of the weight: less than a tenth."""
LEAST_ALONE = 0.8
"""While the other foot is in the air, one carries at least this share of the weight above its zero:
data sheets and weights are not further off."""
LEAST_LOADED = 0.25
"""The same of the most that a foot carries, where the other is never in the air."""
NOISE_RANGE = 3.5
"""Between the 5th and 95th percentile of noise, over the median of its steps."""


@dataclass(frozen=True)
class Contact:
    """What two feet do at T instants.

    Attributes:
        air: (T, 2) the foot is in the air.
        load: (T, 2) what it carries as a share of the weight; NaN for a foot that is never in the
            air, whose zero is not known.
    """

    air: BoolArray
    load: FloatArray


def find_contact(shoe: Shoe, readings: FloatArray, clearance: FloatArray, weight: float) -> Contact:
    """Which feet are in the air, and what they carry.

    Args:
        shoe: with data sheets or without.
        readings: (T, n) raw.
        clearance: (T, 2) height of each sole's lowest corner above the other's lowest [m].
        weight: of robot and shoes [N].
    """
    force, known = vertical_forces(shoe, readings)
    high = clearance > CLEARANCE_M
    sure = np.stack([_surely(clearance[:, foot], high[:, foot]) for foot in (0, 1)], axis=1)
    air, load = np.zeros_like(high), np.full(force.shape, np.nan)
    for foot in (0, 1):
        if sure[:, foot].sum() < LEAST_SURE:
            continue
        above = force[:, foot] - np.median(force[sure[:, foot], foot])
        lifted = sure[:, 1 - foot].sum() >= LEAST_SURE
        most = np.median(above[sure[:, 1 - foot]]) if lifted else np.percentile(above, 98.0)
        if known[foot]:
            span = weight
            agrees = most >= (LEAST_ALONE if lifted else LEAST_LOADED) * weight
        else:
            span = float(most)
            agrees = -np.percentile(above, 1.0) <= LOWEST_SHARE * span
        if agrees and span > 0.0:
            load[:, foot] = above / span
            air[:, foot] = high[:, foot] & (np.abs(load[:, foot]) < NEAR_ZERO)
    return Contact(air, load)


def moves(shoe: Shoe, readings: FloatArray, part: IntArray, foot: int) -> bool:
    """Whether a foot's vertical force changes in some of the readings (T, n): it is not in the air.

    False where the polarity of vertical channels is not known.
    """
    if not polarity_known(shoe):
        return False
    force = vertical_forces(shoe, readings)[0][:, foot]
    least, most = np.percentile(force, [1.0, 99.0])
    low, high = np.percentile(force[part], [5.0, 95.0])
    noise = float(np.median(np.abs(np.diff(force[part])))) if len(part) > 1 else 0.0
    return bool(high - low - NOISE_RANGE * noise > LOWEST_SHARE * (most - least))


def _surely(clearance: FloatArray, high: BoolArray) -> BoolArray:
    """(T,) the foot is as high as it mostly gets."""
    if not high.any():
        return high
    most = float(np.percentile(clearance[high], 95.0))
    surely: BoolArray = high & (clearance > SURE_SHARE * most)
    return surely
