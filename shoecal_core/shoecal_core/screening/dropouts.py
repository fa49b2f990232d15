"""Angles that were not read: a servo that does not answer keeps its last one, or shows another.

An angle that stands exactly still for a while, and then steps by far more than it ever does, was
held. One that jumps away and is back with the next message was none: no joint moves like that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.samples.stretches import Stretch, list_stretches
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding, name_runs

USUAL = 0.9
"""Of the changes from one angle to the next, that are usual."""
CHANGES = 20
"""From which they are known."""
STEPS = 8.0
"""Usual changes that a step is larger than."""
HELD_S, STEP_RAD = 1.0, 0.01
"""Time that an angle is held, and the step at its end, at least. None of 195 recordings, simulated
and real, has one; quick motions begin with smaller ones."""
JUMP_RAD, JUMPS = 0.02, 3
"""Size of jumps, and how many of them in a session, at least. None of these recordings has any."""
SAME_RAD, SAME_SHARE = 0.001, 0.5
"""Jumps end at one angle where more than this share of them does, to within the first: the angle
between two jumps looks like one."""


@dataclass(frozen=True)
class Dropouts:
    """What was not read of one joint.

    Attributes:
        joint: its name.
        held: by run, stretches in which it kept an angle [s].
        step: the largest at the end of one [rad].
        jumps: by run, angles that it showed for one message [rad].
    """

    joint: str
    held: Mapping[int, Sequence[Stretch]]
    step: float
    jumps: Mapping[int, FloatArray]


def find_dropouts(runs: Mapping[int, Run], joints: Iterable[str]) -> list[Dropouts]:
    """Of some joints; those without any are left out."""
    found = []
    for joint in joints:
        held, jumps, step = dict[int, list[Stretch]](), dict[int, FloatArray](), 0.0
        for number, run in runs.items():
            if joint not in run.joints.names:
                continue
            angles = run.joints.position[:, run.joints.names.index(joint)]
            known = np.isfinite(angles)
            angles, time = angles[known], run.joints.time[known]
            usual = _usual(angles)
            away = _jumps(angles, max(JUMP_RAD, STEPS * usual))
            if away.any():
                jumps[number] = angles[away]
            stretches, steps = _held(angles[~away], time[~away], max(STEP_RAD, STEPS * usual))
            if stretches:
                held[number], step = stretches, max(step, *steps)
        if sum(map(len, jumps.values())) < JUMPS:
            jumps = {}
        if held or jumps:
            found.append(Dropouts(joint, held, step, jumps))
    return found


def _usual(angles: FloatArray) -> float:
    """Size of a usual change of angles (T,) [rad]; infinite where there are too few."""
    changes = np.abs(np.diff(angles))
    moved = changes[changes > 0.0]
    return float(np.quantile(moved, USUAL)) if len(moved) >= CHANGES else np.inf


def _held(angles: FloatArray, time: FloatArray, least: float) -> tuple[list[Stretch], list[float]]:
    """Stretches of equal angles (T,), at times (T,), that end with a step; these steps [rad]."""
    step = np.abs(np.diff(angles))
    ends = np.flatnonzero(step > 0.0)
    first = np.concatenate(([0], ends[:-1] + 1))[: len(ends)]
    chosen = (time[ends] - time[first] >= HELD_S) & (step[ends] > least)
    return (
        [
            (float(time[a]), float(time[b]))
            for a, b in zip(first[chosen], ends[chosen], strict=True)
        ],
        step[ends[chosen]].tolist(),
    )


def _jumps(angles: FloatArray, least: float) -> BoolArray:
    """Which of angles (T,) are far off the one before and the one after [rad]."""
    before, there, after = angles[:-2], angles[1:-1], angles[2:]
    away = np.minimum(np.abs(there - before), np.abs(there - after)) > least
    # A joint that turns round at full speed goes on: it does not come back to where it was.
    back = np.abs(after - before) < 0.5 * np.abs(there - before)
    return np.pad(away & back, 1)


def describe_dropouts(found: Sequence[Dropouts]) -> list[Finding]:
    """A line for each joint and kind."""
    texts = []
    for one in found:
        if one.held:
            when = "; ".join(f"run {run} {list_stretches(held)}" for run, held in one.held.items())
            texts.append(
                f"{one.joint} keeps one angle while the robot moves, and then steps by up to "
                f"{one.step:.2g} rad ({when}): its servo or encoder did not answer; check its bus "
                "and power, and record these runs again"
            )
        if one.jumps:
            angles = np.concatenate(list(one.jumps.values()))
            to = float(np.median(angles))
            same = np.mean(np.abs(angles - to) < SAME_RAD) > SAME_SHARE
            where = f"falls to {to:.3g} rad" if same else "jumps to another angle"
            texts.append(
                f"{one.joint} {where} in {len(angles)} messages of {name_runs(list(one.jumps))} "
                "and is back in the next: its servo did not answer, and the driver sent that "
                "angle; let it leave such angles out, or send NaN, and record these runs again"
            )
    return [Finding("FAIL", text, Fault.NOT_READ) for text in texts]
