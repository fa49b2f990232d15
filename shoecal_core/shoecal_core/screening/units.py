"""Are the readings of six-axis sensors in the units that the shoe file says?

Gains that a rough fit finds without the data sheets are so many times theirs as a reading is
newtons or newton metres: N mm that are taken for N m make all gains of moments 0.001.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.rough_fit import fit_roughly
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.units import FORCES, MOMENTS, named_unit

OTHER_UNIT = 3.0
"""Data sheets are not so many times wrong; units are."""
UNIT_SHARE, AGREEING = 0.3, 2.0
"""Share by which the usual rough gain may be off a unit, and by how many times single ones are off
the usual one."""
KNOWN_SHARE = 0.3
"""Of a gain, its standard deviation at most: those of sideways forces are not known."""


@dataclass(frozen=True)
class OtherUnit:
    """Channels that read in another unit.

    Attributes:
        kind: forces or moments.
        channels: indices of those that show it.
        size: of the unit [N or N m].
        name: of the unit.
    """

    kind: str
    channels: tuple[int, ...]
    size: float
    name: str


def other_units(
    shoe: Shoe, aligned: Mapping[int, Aligned], weight: float, settings: CalibrationSettings
) -> list[OtherUnit]:
    """Forces and moments of six-axis sensors that read in other units than N and N m.

    Args:
        aligned: runs in double support.
        weight: of robot and shoes [N].
    """
    if not aligned or not shoe.torque.any():
        return []
    parts = {run: blocks(one, shoe) for run, one in aligned.items()}
    fit = fit_roughly(shoe, parts, weight, settings)
    gain, std = (one[: len(shoe.names)] for one in (fit.vector, np.sqrt(np.diag(fit.covariance))))
    sheet = np.array([abs(one.nominal_gain or np.nan) for one in shoe.channels])
    ratio = np.abs(gain) / sheet
    known = np.isfinite(ratio) & (std < KNOWN_SHARE * np.abs(gain))
    found = []
    kinds = (("forces", shoe.vertical, FORCES), ("moments", shoe.torque, MOMENTS))
    for kind, own, units in kinds:
        shown = np.flatnonzero(own & known)
        if not len(shown):
            continue
        usual = float(np.median(ratio[shown]))
        apart = float(np.max(np.abs(np.log(ratio[shown] / usual))))
        unit = named_unit(usual, units, UNIT_SHARE)
        if unit and abs(np.log(usual)) > np.log(OTHER_UNIT) and apart < np.log(AGREEING):
            found.append(OtherUnit(kind, tuple(shown.tolist()), *unit))
    return found
