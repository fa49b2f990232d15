"""What data sheets of sensors say of gains and of the robot's weight, against what a fit says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.estimation.weight import Weighed
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.units import FORCES, named_unit
from shoecal_core.shoe.wrench import ChannelParameters

NOMINAL_SHARE = 0.05
"""Data sheets of gains, and weights, are right to this share."""
SHEET_SHARE, SHEET_STDS = 0.1, 2.0
"""A single gain is unlike its data sheet beyond this share and so many standard deviations."""
CONFLICT_STDS = 5.0
"""Standard deviations, of what is believed of data sheets, beyond which a gain contradicts its."""
UNITS = {**FORCES, 2.0: "mV/V of half a bridge", 0.5: "mV/V of two bridges"}
"""What readings are in that a gain so many times its data sheet's turns into newtons."""
UNIT_SHARE, AGREEING = 0.06, 0.2
"""Shares by which the usual gain may be off such a ratio, and each gain off the usual one."""
LARGEST_UNIT = 2000.0
"""Gains that differ from their data sheets by more are of counts, not of a unit of force."""


def sheet_ratios(shoe: Shoe, parameters: ChannelParameters) -> FloatArray:
    """(n,) ratio of each gain to its data sheet's; NaN where there is none."""
    sheet = np.array([abs(one.nominal_gain or np.nan) for one in shoe.channels])
    ratio: FloatArray = np.abs(parameters.gain) / sheet
    return ratio


def contradicts(shoe: Shoe, parameters: ChannelParameters, sheet_std: float) -> bool:
    """Whether any gain is further from its data sheet than one can be that is believed.

    Args:
        sheet_std: standard deviation of data sheets' gains, over the gain.
    """
    return bool(len(_far(sheet_ratios(shoe, parameters), sheet_std)))


def _far(ratio: FloatArray, sheet_std: float) -> IntArray:
    """Channels whose gains contradict their data sheets; where there is none, none does."""
    return np.flatnonzero(np.abs(ratio - 1.0) > CONFLICT_STDS * sheet_std)


def check_conflict(
    shoe: Shoe,
    parameters: ChannelParameters | None,
    alone: ChannelParameters | None,
    sheet_std: float,
) -> list[Finding]:
    """Gains that are a compromise of data and data sheets that contradict each other.

    Args:
        shoe, parameters: of n channels, fitted with the data sheets; None: nothing was.
        alone: the same fitted without them; None where that could not be done.
        sheet_std: as for `contradicts`.
    """
    if parameters is None:
        return []
    ratio = sheet_ratios(shoe, parameters)
    far = _far(ratio, sheet_std)
    if not len(far):
        return []
    listed = ", ".join(f"{shoe.names[index]} {ratio[index]:.3g}" for index in far)
    text = f"gains contradict their data sheets (share of it: {listed})"
    if alone is not None:
        free = sheet_ratios(shoe, alone)
        vertical = np.flatnonzero(np.isfinite(free) & shoe.vertical)
        shown = vertical if len(vertical) else far
        text += ", without the data sheets the data give " + ", ".join(
            f"{shoe.names[index]} {free[index]:.3g}" for index in shown
        )
        text += _likely(free[shown])
    return [
        Finding("FAIL", f"{text}; correct 'nominal_gain' in the shoe file, or take it out of there")
    ]


def _likely(ratios: FloatArray) -> str:
    """The unit that explains ratios which agree."""
    ratio = float(np.median(ratios))
    if np.abs(ratios / ratio - 1.0).max() > AGREEING:
        return ""
    if unit := named_unit(ratio, UNITS, UNIT_SHARE):
        return f": are the readings in {unit[1]}?"
    if not 1.0 / LARGEST_UNIT < ratio < LARGEST_UNIT:
        return ": are the readings counts of a converter?"
    return ""


def check_weight(
    shoe: Shoe,
    parameters: ChannelParameters,
    gain_std: FloatArray | None,
    weighed: Weighed | None,
    robot: Robot,
) -> list[Finding]:
    """The robot file's weight against what the data sheets of the sensors make of it.

    Where they cannot weigh the robot, vertical gains that all differ from them alike say so.

    Args:
        gain_std: (n,) standard deviations; None where they are not known.
    """
    if weighed is not None:
        if abs(weighed.kg / robot.mass - 1.0) <= NOMINAL_SHARE:
            return []
        return [Finding("WARN", weight_text(weighed, robot))]
    ratio = sheet_ratios(shoe, parameters)
    vertical = np.isfinite(ratio) & shoe.vertical
    if not vertical.any():
        return []
    ratios = ratio[vertical]
    common = float(np.median(ratios))
    stds = np.zeros(len(ratios))
    if gain_std is not None:
        stds = (gain_std / np.abs(parameters.gain))[vertical] * ratios
    agree = np.abs(ratios - common) <= np.maximum(NOMINAL_SHARE * common, SHEET_STDS * stds)
    if abs(common - 1.0) <= NOMINAL_SHARE or not agree.all():
        return []
    return [
        Finding(
            "WARN",
            f"the vertical gains are {common:.2f} of their data sheets': the robot weighs "
            f"{robot.mass / common:.1f} kg by them and {robot.mass:.1f} kg by its file; put it on "
            f"a scale, or try --weight-kg {robot.mass / common:.1f}",
        )
    ]


def weight_text(weighed: Weighed, robot: Robot) -> str:
    """Both weights in words."""
    low, high = weighed.ci95
    text = (
        f"by the data sheets of its sensors the robot weighs {weighed.kg:.1f} kg (95 %: {low:.1f} "
        f"to {high:.1f} kg, zeros of each run taken off), by its file {robot.mass:.1f} kg"
    )
    if abs(weighed.kg / robot.mass - 1.0) <= NOMINAL_SHARE:
        return text
    return f"{text}; put it on a scale, or try --weight-kg {weighed.kg:.1f}"


def check_data_sheets(
    shoe: Shoe, parameters: ChannelParameters, gain_std: FloatArray
) -> list[Finding]:
    """Gains that differ from their data sheets by more than the other channels of their kind, and
    by more than they are uncertain.

    Args:
        shoe, parameters: of n channels.
        gain_std: (n,) standard deviations.
    """
    ratio = sheet_ratios(shoe, parameters)
    known = np.flatnonzero(np.isfinite(ratio)).tolist()
    unlike = []
    for index in known:
        kind = [i for i in known if shoe.vertical[i] == shoe.vertical[index]]
        # A wrong weight changes all vertical gains alike: it is a finding of its own.
        usual = float(np.median(ratio[kind])) if shoe.vertical[index] else 1.0
        std = gain_std[index] / abs(parameters.gain[index]) * ratio[index]
        if abs(ratio[index] - usual) > max(SHEET_SHARE, SHEET_STDS * std):
            unlike.append(f"{shoe.names[index]} {ratio[index]:.2f} ± {1.96 * std:.2f}")
    if not unlike:
        return []
    return [
        Finding(
            "WARN",
            f"gains differ from their data sheets (share of it, 95 %): {', '.join(unlike)}; check "
            "these channels' axes and units in the shoe file",
        )
    ]


def without_sheets(shoe: Shoe) -> Shoe:
    """The same shoe without nominal gains."""
    return replace(shoe, channels=tuple(replace(one, nominal_gain=None) for one in shoe.channels))
