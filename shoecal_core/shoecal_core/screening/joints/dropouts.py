"""Angles that were held: a servo that does not answer, or an encoder, keeps its last one.

An angle that stands exactly still for a while, and then steps by far more than it ever does, was
held. Angles that fall to zero for a moment are left out when a run is read.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.samples.stretches import Stretch, list_stretches
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

USUAL = 0.9
"""Of the changes from one angle to the next, that are usual."""
CHANGES = 20
"""From which they are known."""
STEPS = 8.0
"""Usual changes that a step is larger than."""
HELD_S, STEP_RAD = 1.0, 0.01
"""Time that an angle is held, and the step at its end, at least. None of 195 recordings, simulated
and real, has one; quick motions begin with smaller ones."""


@dataclass(frozen=True)
class Dropouts:
    """When one joint's angle was held.

    Attributes:
        joint: its name.
        held: by run, stretches in which it kept an angle [s].
        step: the largest at the end of one [rad].
    """

    joint: str
    held: Mapping[int, Sequence[Stretch]]
    step: float


def find_dropouts(runs: Mapping[int, Run], joints: Iterable[str]) -> list[Dropouts]:
    """Of some joints; those without any are left out."""
    found = []
    for joint in joints:
        held, step = dict[int, list[Stretch]](), 0.0
        for number, run in runs.items():
            if joint not in run.joints.names:
                continue
            angles = run.joints.position[:, run.joints.names.index(joint)]
            known = np.isfinite(angles)
            stretches, steps = _held(angles[known], run.joints.time[known])
            if stretches:
                held[number], step = stretches, max(step, *steps)
        if held:
            found.append(Dropouts(joint, held, step))
    return found


def _held(angles: FloatArray, time: FloatArray) -> tuple[list[Stretch], list[float]]:
    """Stretches of equal angles (T,), at times (T,), that end with a step; these steps [rad]."""
    step = np.abs(np.diff(angles))
    ends = np.flatnonzero(step > 0.0)
    if len(ends) < CHANGES:
        return [], []
    least = max(STEP_RAD, STEPS * float(np.quantile(step[ends], USUAL)))
    first = np.concatenate(([0], ends[:-1] + 1))
    # One wrong angle is back in the next message.
    lasts = np.abs(angles[np.minimum(ends + 2, len(angles) - 1)] - angles[ends]) > step[ends] / 2.0
    chosen = (time[ends] - time[first] >= HELD_S) & (step[ends] > least) & lasts
    held = zip(time[first[chosen]].tolist(), time[ends[chosen]].tolist(), strict=True)
    return list(held), step[ends[chosen]].tolist()


def describe_dropouts(found: Sequence[Dropouts]) -> list[Finding]:
    """A line for each joint."""
    return [
        Finding(
            "FAIL",
            f"{one.joint} keeps one angle while the robot moves, and then steps by up to "
            f"{one.step:.2g} rad ("
            + "; ".join(f"run {run} {list_stretches(held)}" for run, held in one.held.items())
            + "): its servo or encoder did not answer; check its bus and power, and record these "
            "runs again",
            Fault.HELD,
        )
        for one in found
    ]
