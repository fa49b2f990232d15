"""Feet that moved once on the floor: steps of the closure.

`step_times` asks when a course most looks as if it had made a step, whatever else it does: moments
that a fit then judges. `step_of` asks whether it made one that stays, and needs no fit: the closure
knows no force sensor, so that runs may be looked at which test the fits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import CLOSURE

BEFORE_S, AWAY_S = 1.5, 0.4
"""Long and so far from a step that the closure before and after it is looked at."""
LEAST = 2e-3
"""Step that counts: m, or rad times `ARM_M`."""
ARM_M = 0.1
"""Turns count as what they move at this distance."""
STANDS_OUT = 3.0
"""Times what else the closure does in as short a time, anywhere in that run."""
STAYS = 0.5
"""Share of the step that the whole course after it differs from the whole course before."""

ONSETS = 2
"""Moments in a run at which a slip is looked for."""
EDGE = 5
"""Samples at a run's ends among which no step can be detected."""


@dataclass(frozen=True)
class Step:
    """One step of the closure.

    Attributes:
        run: in which.
        time: since its start [s].
        shift: (3,) of the right foot in the left one's frame [m, m, rad].
    """

    run: int
    time: float
    shift: FloatArray


def closure_steps(signal_model: SignalModel) -> Iterator[Step]:
    """The step of each run that has one."""
    samples = signal_model.samples
    for track in samples.tracks:
        here = (samples.run == track.run) & samples.both & signal_model.mask[:, CLOSURE.start]
        # Feet that are lifted may stand elsewhere afterwards.
        if track.walks or len(np.unique(samples.segment[here])) != 1:
            continue
        found = step_of(samples.time[here], signal_model.residuals[here, CLOSURE][:, [0, 1, 5]])
        if found is not None:
            yield Step(track.run, *found)


def step_of(time: FloatArray, closure: FloatArray) -> tuple[float, FloatArray] | None:
    """When a course (T, 3) makes a step that stays, and how large."""
    course = closure * [1.0, 1.0, ARM_M]
    jumps = np.array([_jump(time, course, at) for at in time])
    sizes = np.linalg.norm(jumps, axis=1)
    best = int(np.argmax(sizes))
    # A step shows in all windows that it falls into.
    elsewhere = sizes[np.abs(time - time[best]) > 2.0 * (BEFORE_S + AWAY_S)]
    if sizes[best] < max(LEAST, STANDS_OUT * elsewhere.max(initial=0.0)):
        return None
    before, after = course[time < time[best] - AWAY_S], course[time > time[best] + AWAY_S]
    lasting = np.median(after, axis=0) - np.median(before, axis=0)
    if lasting @ jumps[best] < STAYS * sizes[best] ** 2:
        return None
    # Halfway through it the foot moves: where the course is nearest to the middle of both levels.
    return float(_onset(time, course, best, jumps[best])), jumps[best] / [1.0, 1.0, ARM_M]


def step_times(time: FloatArray, signals: FloatArray) -> list[float]:
    """When signals (T, k) most look as if they had made a step [s]; none of a short course.

    The mean before and after a moment parts a course best. Each signal counts by its own scatter
    within short times, so that no noise need be known.
    """
    count = len(time)
    if count < 4 * EDGE:
        return []
    scatter = np.std(np.diff(signals, axis=0), axis=0)
    signals = signals[:, scatter > 0.0] / scatter[scatter > 0.0]
    sums = np.cumsum(signals - signals.mean(axis=0), axis=0)
    before = np.arange(1, count + 1)
    split = (sums**2).sum(axis=1) * count / np.maximum(before * (count - before), 1)
    split[:EDGE] = split[-EDGE:] = 0.0
    found = []
    for _ in range(ONSETS):
        at = int(np.argmax(split))
        found.append(float(0.5 * (time[at] + time[at + 1])))
        split[max(0, at - 2 * EDGE) : at + 2 * EDGE] = 0.0
    return found


def _jump(time: FloatArray, course: FloatArray, at: float) -> FloatArray:
    """(3,) from shortly before a moment to shortly after it; none near the ends."""
    away = time - at
    before = (away < -AWAY_S) & (away > -AWAY_S - BEFORE_S)
    after = (away > AWAY_S) & (away < AWAY_S + BEFORE_S)
    if min(np.count_nonzero(before), np.count_nonzero(after)) < 3:
        return np.zeros(course.shape[1])
    jump: FloatArray = course[after].mean(axis=0) - course[before].mean(axis=0)
    return jump


def _onset(time: FloatArray, course: FloatArray, best: int, jump: FloatArray) -> float:
    """First moment near the best one from which more than half of the jump is made [s]."""
    near = np.abs(time - time[best]) <= BEFORE_S
    early = time - time[best] + BEFORE_S
    before = np.median(course[(early > -AWAY_S) & (early < AWAY_S)], axis=0)
    made = (course - before) @ jump / (jump @ jump)
    later = np.flatnonzero(near & (made > 0.5))
    return float(time[later[0]]) if len(later) else float(time[best])
