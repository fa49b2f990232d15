"""Sideways axes of ankle sensors that are reversed or turned.

On one foot the floor's sideways force is the robot's mass times the acceleration of its CoM. A
sideways axis parallel to the sole's follows it with a slope of 1. What the model of a walk misses
recurs in every step, so a run counts once, and a finding needs runs that agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.six_axis.sideways import AXES
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

LEAST_RUNS = 3
LEAST_SAMPLES = 50
LEAST_SLOPE = 0.1
"""Slopes nearer to zero say nothing, however sure they are."""


@dataclass(frozen=True)
class SidewaysAxes:
    """Slopes of one foot's sideways axes on the sideways force.

    Attributes:
        foot: index into FEET.
        slope: (2, 2) of fx, fy (rows) on the sole's x, y (columns); mean over runs.
        half: (2, 2) half of their 95 % intervals.
        runs: how many.
    """

    foot: int
    slope: FloatArray
    half: FloatArray
    runs: int

    @property
    def reversed(self) -> tuple[str, ...]:
        """Axes that move against the force."""
        return tuple(
            name
            for index, name in enumerate(AXES)
            if self.slope[index, index] + self.half[index, index] < -LEAST_SLOPE
        )

    @property
    def turned(self) -> bool:
        """Each axis follows the other one's force, and its own less."""
        across = np.abs(self.slope[[0, 1], [1, 0]])
        sure = across - self.half[[0, 1], [1, 0]] > LEAST_SLOPE
        return bool(np.all(sure & (across > np.abs(np.diag(self.slope)))))


def sideways_axes(shoe: Shoe, stances: Sequence[Stance]) -> list[SidewaysAxes]:
    """What single supports of a walk show; nothing with too few runs or without such axes."""
    found = []
    for foot, name in enumerate(FEET):
        wanted = [f"{name}/{axis}" for axis in AXES]
        if not set(wanted) <= set(shoe.names):
            continue
        channels = [shoe.index(one) for one in wanted]
        gain = [shoe.channels[i].rough_gain for i in channels]
        alone = [one for one in stances if one.push is not None and one.hanging == 1 - foot]
        slopes = []
        for run in sorted({one.run for one in alone}):
            pairs = [
                (one.push, one.readings[:, channels] * gain) for one in alone if one.run == run
            ]
            push, shown = (
                np.concatenate([part - part.mean(axis=0) for part in parts if part is not None])
                for parts in zip(*pairs, strict=True)
            )
            if len(push) >= LEAST_SAMPLES:
                slopes.append(np.linalg.lstsq(push, shown, rcond=1e-6)[0].T)
        if len(slopes) >= LEAST_RUNS:
            each = np.array(slopes)
            spread = each.std(axis=0, ddof=1) / np.sqrt(len(each))
            half = stdtrit(len(each) - 1, 0.975) * spread
            found.append(SidewaysAxes(foot, each.mean(axis=0), half, len(each)))
    return found


def check_axes(shoe: Shoe, stances: Sequence[Stance]) -> list[Finding]:
    """Axes to turn in the shoe file, with what speaks for it."""
    feet = sideways_axes(shoe, stances)
    findings = []
    against = [
        f"{FEET[one.foot]}/{name} {one.slope[index, index]:+.2f} ± {one.half[index, index]:.2f}"
        for one in feet
        for index, name in enumerate(AXES)
        if name in one.reversed
    ]
    if against:
        findings.append(
            Finding(
                "WARN",
                f"these axes move against the sideways force (slope on mass times acceleration in "
                f"single supports of {feet[0].runs} runs, 95 %; +1 if they were right): "
                f"{', '.join(against)}; push the standing robot forward and to the left to see, "
                "then reverse their polarity in the shoe file",
            )
        )
    findings += [
        Finding(
            "WARN",
            f"{FEET[one.foot]}/fx and {FEET[one.foot]}/fy each follow the other one's sideways "
            f"force (slopes {one.slope[0, 1]:+.2f} and {one.slope[1, 0]:+.2f} over {one.runs} "
            "runs): the sensor seems turned by a right angle; exchange the two in the shoe file",
        )
        for one in feet
        if one.turned
    ]
    return findings
