"""Vertical forces that do not add up to the weight, and nothing that is looked for explains it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Equations, reweighed, solve
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding

LIMIT_STDS = 1.2
"""Of the settings' standard deviations of the force (RMS). Sound recordings come to 0.1 to 0.4,
simulated and real, those with noisy six-axis sensors to 0.9; amplifiers that track their zero to
1.7."""


def unexplained(
    rows: Mapping[int, Equations], information: FloatArray, settings: CalibrationSettings
) -> float:
    """By how much the vertical forces vary about the weight (RMS) [N]; 0 where it is little.

    Args:
        rows: equations of each run.
        information: (2n,) prior, of gains and offsets.
    """
    rows = reweighed(rows, information)
    vector = solve(rows, information).vector
    squares = sum(one.force_squares(vector) for one in rows.values())
    stds = float(np.sqrt(squares / sum(float(one.weight.sum()) for one in rows.values())))
    return settings.force_std_n * stds if stds > LIMIT_STDS else 0.0


def describe_unexplained(size: float) -> list[Finding]:
    """Forces that vary by so much [N]."""
    if size == 0.0:
        return []
    return [
        Finding(
            "WARN",
            f"the vertical forces vary by {size:.1f} N (RMS) about the robot's weight, and nothing "
            "that is looked for explains it: see that amplifiers neither track their zeros nor "
            "filter, that screws are tight and the supply is steady; `shoecal diagnose` looks "
            "further",
            Fault.UNEXPLAINED,
        )
    ]
