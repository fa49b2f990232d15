"""How channels share a load: outputs of a rigid body that stands on equal springs."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import at_cop, columns_in_left, combined, weight_below


def double_support_outputs(
    shoe: Shoe, support: DoubleSupport, force: float, places: FloatArray
) -> FloatArray:
    """(p, n) outputs [N or N m] under both feet together.

    Args:
        shoe: with n channels.
        support: where the right foot is.
        force: on the floor, the parts below the channels included [N].
        places: (p, 2) CoP in the left sole's frame [m].
    """
    carried = _wrench(force, places) - combined(weight_below(shoe), support)
    return carried @ np.linalg.pinv(columns_in_left(shoe, support))


def single_support_outputs(shoe: Shoe, foot: int, force: float, places: FloatArray) -> FloatArray:
    """(p, n) outputs [N or N m] under one foot; the other hangs and reads zero force and moments.

    Args:
        shoe: with n channels.
        foot: that stands.
        force: on the floor, the parts below its channels included [N].
        places: (p, 2) CoP in its sole frame [m].
    """
    outputs = np.zeros((len(places), len(shoe.channels)))
    for each in (0, 1):
        own = shoe.of_foot(each)
        standing = force if each == foot else 0.0
        carried = _wrench(standing, places) - weight_below(shoe)[each]
        outputs[:, own] = carried @ np.linalg.pinv(shoe.columns[own])
    return outputs


def _wrench(force: float, places: FloatArray) -> FloatArray:
    return at_cop(np.full(len(places), force), places)
