"""Joint angles in coarse steps: few digits in a file, or encoders of few bits.

An angle in steps is off by up to half of one, step / sqrt(12) in the root mean square, and tilts
the robot on its sole by that. A staircase looks like jerky motion, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding

LEAST_LEVELS = 5
"""Different angles of a joint that show its step; one that stands still shows none."""
MOST_JOINTS = 0.5
"""Of the legs' joints that show steps, that share has to have coarse ones: a single encoder tilts
the robot by less."""
NAMED_SHARE, REFUSED_SHARE = 0.5, 1.0
"""Of the model's error as a tilt (`model_error_rad`), from which what steps add is reported, and
refused. So with 2 mrad: from 3.5 and 6.9 mrad. Measured (Wren): the expected error of the CoP grows
from 1.1 mm to 1.2 mm with 5 and 6 mrad, servos of 10 bits, and to 1.9 mm with 10 mrad."""


def coarse_step(runs: Iterable[Run], joints: Iterable[str], settings: CalibrationSettings) -> float:
    """Median step of the angles of some joints [rad]; 0 where it does no harm.

    Args:
        runs: of one session.
        joints: of the legs.
    """
    found: dict[str, float] = {}
    for run in runs:
        for name, angles in zip(run.joints.names, run.joints.position.T, strict=True):
            step = _step(angles)
            if step is not None:
                found[name] = min(step, found.get(name, math.inf))
    steps = np.array([found[name] for name in joints if name in found])
    if not len(steps):
        return 0.0
    coarse = steps / math.sqrt(12.0) > NAMED_SHARE * settings.model_error_rad
    return float(np.median(steps[coarse])) if coarse.mean() > MOST_JOINTS else 0.0


def _step(angles: FloatArray) -> float | None:
    """The smallest between two angles (T,) that occur; None of too few."""
    levels = np.unique(angles[np.isfinite(angles)])
    return float(np.diff(levels).min()) if len(levels) >= LEAST_LEVELS else None


def describe_steps(step: float, settings: CalibrationSettings) -> list[Finding]:
    """Angles in steps [rad] that cost CoP, by what `coarse_step` finds."""
    if step == 0.0:
        return []
    refused = step / math.sqrt(12.0) > REFUSED_SHARE * settings.model_error_rad
    cure = (
        "export them with more digits, or read the encoders with more bits"
        if refused
        else "export them with more digits if the encoders have them; moments that seem too fast "
        "by their steps are left out"
    )
    return [
        Finding(
            "FAIL" if refused else "WARN",
            f"joint angles come in steps of {1e3 * step:.3g} mrad ({math.degrees(step):.2g} deg), "
            f"which makes the CoP unsure: {cure}",
            Fault.COARSE_ANGLES,
        )
    ]


def without_motion(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings without those of motion that is too fast: coarse steps look like it."""
    return tuple(one for one in findings if one.fault is not Fault.TOO_FAST)
