"""Vertical force of each foot by data sheets, and which feet carry load by how it changes.

The zeros of the channels are not known here, so a foot that reads its least may hang or carry
little; one that reads more carries load.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.shoe.shoe import FEET, Shoe

LOWEST_SHARE = 0.08
"""A foot in the air reads its least, to within this share of the range, and keeps to it."""
LEAST_RANGE = 10.0
"""Of a foot's force, over the median of its steps, from which it is load that comes and goes and
not noise."""


def vertical_forces(shoe: Shoe, readings: FloatArray) -> tuple[FloatArray, BoolArray]:
    """(T, 2) vertical force of each foot by data sheets, its zero left in; in N where (2,) is True.

    Raises:
        ShoecalError: a vertical channel's polarity is not known.
    """
    forces, known = [], []
    for foot in (0, 1):
        vertical = [i for i in shoe.of_foot(foot) if shoe.vertical[i]]
        if any(shoe.polarity[i] == 0 for i in vertical):
            raise ShoecalError(
                f"shoe '{shoe.name}': give the polarity of the {FEET[foot]} foot's vertical "
                "channels; the stances of a walk are found by which foot carries load"
            )
        gains = [shoe.channels[i].nominal_gain for i in vertical]
        known.append(bool(vertical) and None not in gains)
        size = np.abs([1.0 if gain is None else gain for gain in gains])
        forces.append(readings[:, vertical] @ (shoe.polarity[vertical] * size))
    return np.stack(forces, axis=1), np.array(known)


def polarity_known(shoe: Shoe) -> bool:
    """Of every vertical channel."""
    return not any(shoe.polarity[i] == 0 for i in np.flatnonzero(shoe.columns[:, 0]))


def at_least_load(shoe: Shoe, readings: FloatArray) -> BoolArray:
    """(T, 2) each foot's vertical force is about the least of all T samples.

    That is no proof that it is in the air, but one that carries more is not. All is True where the
    polarity of vertical channels is not known.
    """
    if not polarity_known(shoe):
        return np.ones((len(readings), 2), dtype=bool)
    force, _ = vertical_forces(shoe, readings)
    least, most = np.percentile(force, [1.0, 99.0], axis=0)
    low: BoolArray = force - least <= LOWEST_SHARE * (most - least)
    return low


def both_carry_load(shoe: Shoe, readings: FloatArray) -> BoolArray | None:
    """(T,) both feet carry load, for they read more than their least.

    Args:
        readings: (T, n) raw, at the device's own rate; what is not finite carries no proof.

    Returns:
        None where that is not known: the load on a foot never changes, or polarities are missing.
    """
    good = np.isfinite(readings).all(axis=1)
    if good.sum() < 2 or not polarity_known(shoe) or not shoe.vertical.any():
        return None
    force, _ = vertical_forces(shoe, readings[good])
    least, most = np.percentile(force, [1.0, 99.0], axis=0)
    noise = np.median(np.abs(np.diff(force, axis=0)), axis=0)
    if (most - least <= LEAST_RANGE * noise).any():
        return None
    both = np.zeros(len(readings), dtype=bool)
    both[good] = ~at_least_load(shoe, readings[good]).any(axis=1)
    return both
