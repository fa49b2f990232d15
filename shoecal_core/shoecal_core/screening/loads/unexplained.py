"""Vertical forces that do not add up to the weight, and nothing that is looked for explains it."""

from __future__ import annotations

import numpy as np

from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.verdict import Finding

LIMIT_STDS = 1.2
"""Of the settings' standard deviations of the force (RMS). Sound recordings come to 0.1 to 0.4,
simulated and real, those with noisy six-axis sensors to 0.9; amplifiers that track their zero to
1.7."""


def unexplained(statics: Statics) -> float:
    """By how much the vertical forces vary about the weight (RMS) [N]; 0 where it is little."""
    rows, std = statics.robust, statics.settings.force_std_n
    squares = sum(one.force_squares(statics.fit.vector) for one in rows.values())
    # The noise of readings explains as much as it adds.
    squares -= sum(
        float(one.weight.sum()) * (statics.trembling(run) / std) ** 2 for run, one in rows.items()
    )
    count = sum(float(one.weight.sum()) for one in rows.values())
    stds = float(np.sqrt(max(squares, 0.0) / count))
    return std * stds if stds > LIMIT_STDS else 0.0


def describe_unexplained(size: float) -> list[Finding]:
    """Forces that vary by so much [N]."""
    if size == 0.0:
        return []
    return [
        Finding(
            "WARN",
            f"the vertical forces vary by {size:.1f} N (RMS) about the robot's weight, and nothing "
            "that is looked for explains it: see that amplifiers neither track their zeros nor "
            "filter, that screws are tight, the supply is steady and no board was exchanged or "
            "set otherwise between the runs; `shoecal diagnose` looks further",
            Fault.UNEXPLAINED,
        )
    ]
