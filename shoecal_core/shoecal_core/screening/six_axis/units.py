"""Are the readings of six-axis sensors in the units that the shoe file says?

Gains that a rough fit finds without the data sheets are so many times theirs as a reading is
newtons or newton metres: N mm that are taken for N m make all gains of moments 0.001.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.units import FORCES, MOMENTS, named_unit
from shoecal_core.shoe.vertical import polarity_known, vertical_forces

OTHER_UNIT = 3.0
"""Data sheets are not so many times wrong; units are."""
UNIT_SHARE, AGREEING = 0.3, 2.0
"""Share by which the usual rough gain may be off a unit, and by how many times single ones are off
the usual one."""
RANGE = (2.0, 98.0)
"""Percentiles between which a walk's readings go: impacts and gaps lie beyond."""
STEP_M = 0.01
"""By so much a foot that is lifted is above the other one: soles that are not level are less."""
KNOWN_SHARE = 0.3
"""Of a gain, its standard deviation at most: those of sideways forces are not known."""
LONGEST_LEVER = 1.0
"""m; of no foot does the CoP go farther. In walks of a REEM-C it goes 0.1 m."""
USUAL_LEVER = 0.07
"""m; by it the unit of moments is named that give a longer one."""


@dataclass(frozen=True)
class OtherUnit:
    """Channels that read in another unit.

    Attributes:
        kind: forces or moments.
        channels: indices of those that show it.
        size: of the unit [N or N m].
        name: of the unit.
        shown_by: how it is known.
    """

    kind: str
    channels: tuple[int, ...]
    size: float
    name: str
    shown_by: str


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
    fit = Statics.of(shoe, parts, weight, settings).fit
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
            shown_by = f"a first fit gives gains of about {unit[0]:.6g} times their nominal_gain"
            found.append(OtherUnit(kind, tuple(shown.tolist()), *unit, shown_by))
    return found


def units_of_walks(shoe: Shoe, walks: Mapping[int, Aligned], weight: float) -> list[OtherUnit]:
    """The same by what walks show: each foot carries the weight at times, at other times nothing.

    Args:
        walks: runs in which the robot may walk; those in which each foot rises count.
        weight: of robot and shoes [N].
    """
    gains = [one.nominal_gain for one in shoe.channels]
    walks = {number: one for number, one in walks.items() if _steps(one)}
    if not walks or not shoe.torque.any() or None in gains or not polarity_known(shoe):
        return []
    readings = np.concatenate([one.readings for one in walks.values()])
    ranges = np.ptp(np.percentile(readings, RANGE, axis=0), axis=0)
    ranges *= np.abs(np.array(gains, dtype=float))
    loads = np.ptp(np.percentile(vertical_forces(shoe, readings)[0], RANGE, axis=0), axis=0)
    if not loads.all():
        return []
    found, size = [], 1.0
    force = float(np.sqrt(np.prod(loads)))
    unit = named_unit(weight / force, FORCES, UNIT_SHARE)
    agree = abs(np.log(loads[0] / loads[1])) < np.log(AGREEING)
    if unit and agree and abs(np.log(unit[0])) > np.log(OTHER_UNIT):
        size = unit[0]
        shown_by = (
            f"by their nominal_gain each foot's load goes through {force:.3g} N in a walk, "
            f"the weight is {weight:.3g} N"
        )
        channels = np.flatnonzero(shoe.vertical)
        found.append(OtherUnit("forces", tuple(channels.tolist()), *unit, shown_by))
    moments = np.flatnonzero(shoe.torque)
    levers = ranges[moments] / (size * loads[shoe.foot[moments]])
    lever = float(np.median(levers))
    if lever > LONGEST_LEVER:
        small = {one: name for one, name in MOMENTS.items() if one < 1.0}
        near = min(small, key=lambda one: abs(np.log(one * lever / USUAL_LEVER)))
        shown_by = f"by their nominal_gain the CoP goes {lever:.3g} m to and fro on each foot"
        found.append(OtherUnit("moments", tuple(moments.tolist()), near, small[near], shown_by))
    return found


def _steps(aligned: Aligned) -> bool:
    """Whether each foot is lifted at times."""
    low, high = np.percentile(aligned.states.translation[:, 2], RANGE)
    return bool(low < -STEP_M and high > STEP_M)


def describe_units(shoe: Shoe, found: Sequence[OtherUnit]) -> list[Finding]:
    """Six-axis sensors that read in other units than the shoe file says."""
    return [
        Finding(
            "FAIL",
            f"{one.kind} look like {one.name} "
            f"({', '.join(shoe.names[channel] for channel in one.channels)}): {one.shown_by}; "
            f"multiply the nominal_gain of all {one.kind} "
            f"by {one.size:.6g} in the shoe file (or set 'scale' in the mapping of a CSV import)",
            Fault.UNIT,
        )
        for one in found
    ]
