"""What can be said of a reading at once, while the weight is still there."""

from __future__ import annotations

import numpy as np

from shoecal_core.calibration.calibration import Calibration
from shoecal_core.calibration.manual.calibrate import of_shoe
from shoecal_core.calibration.manual.cells import wrong_response
from shoecal_core.calibration.manual.guide import Check
from shoecal_core.calibration.manual.measurements import Entry, Measurements
from shoecal_core.calibration.manual.shoe_loads import wrong_weight
from shoecal_core.model.robot import GRAVITY


def cell_check(before: Measurements, entry: Entry) -> str:
    """Whether another cell than the loaded one responded, or none; empty: all is well."""
    name = entry.load.place
    weights = {other.load.mass for other in before.of_cell(name) if other.load != entry.load}
    if not weights:
        return ""
    return wrong_response(before.with_entry(entry), name)


def shoe_check(cells: Calibration) -> Check:
    """Whether another weight is there than was asked for.

    Args:
        cells: calibration of the single cells.
    """

    def check(before: Measurements, entry: Entry) -> str:
        load = entry.load
        bare = [other for other in before.of_foot(load.foot) if not other.load.place]
        if not load.place or not bare:
            return ""
        one = before.shoe.of_one_foot(load.foot)
        gain = of_shoe(cells, one).parameters.gain
        return wrong_weight(
            load, float(np.sum(gain * (entry.mean - bare[0].mean))), load.mass * GRAVITY
        )

    return check
