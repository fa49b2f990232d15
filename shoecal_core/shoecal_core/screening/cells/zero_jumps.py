"""Zeros that jump in a run: a board that tares in its start-up code, or starts again.

A robot that stands on both feet shifts its weight slowly. Between two samples the load of a foot
hardly changes; where most of its channels jump at once to what a tared one reads, none, and stay,
their zeros did.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import FEET, Shoe

SLOWEST_S = 0.05
"""Between samples: in longer ones a robot can be lifted or put down."""
USUAL = 0.9
"""Quantile of a signal's changes that counts as a usual one: whole steps of a coarse converter have
it where the median change is none."""
STEP = 20.0
"""Usual changes that a channel jumps by: where gears strike, most of a foot's make 5, a tare under
load a hundred."""
LEAST_SHARE = 0.25
"""Of a channel's range in the run, what the jump of one is at least."""
MOST = 0.5
"""Of a foot's channels, a larger part has to jump."""
WINDOW_S = 0.2
"""Before and after, over which a jump stays: over longer ones the robot moves."""
STAYS = 0.3
"""Part of the jump by which what stays may be off it, and what is near it may change."""
NEAR = 4
"""Samples before and after: what lands changes over several."""
ZERO = 0.15
"""Part of the jump that is read after it at most: a robot that starts with a jerk loads its feet
otherwise within a sample, but leaves none of them without load."""
MOVES = 10.0
"""Usual changes that a channel goes through afterwards: else the foot is in the air, or its cable
off."""


@dataclass(frozen=True)
class ZeroJump:
    """A jump of all channels of a foot.

    Attributes:
        run: its number.
        time: since the run's start [s].
        foot: index into FEET.
    """

    run: int
    time: float
    foot: int


def zero_jumps(shoe: Shoe, runs: Mapping[int, Run]) -> list[ZeroJump]:
    """The largest jump of each foot in each run, where that is one of its zeros.

    Args:
        runs: in double support, by number.
    """
    found = []
    for number, run in runs.items():
        for foot in range(len(FEET)):
            time = _jump(shoe, run, foot)
            if time is not None:
                found.append(ZeroJump(number, time, foot))
    return found


def _jump(shoe: Shoe, run: Run, foot: int) -> float | None:
    own = shoe.of_foot(foot)
    good = np.isfinite(run.readings.value[:, own]).all(axis=1)
    time, value = run.readings.time[good], run.readings.value[good][:, own]
    window = round(WINDOW_S * run.readings.rate_hz)
    if run.readings.rate_hz < 1.0 / SLOWEST_S or len(time) < 4 * window:
        return None
    change = np.diff(value, axis=0)
    usual = np.quantile(np.abs(change), USUAL, axis=0) + 1e-12 * np.ptp(value, axis=0) + 1e-300
    at = int(np.argmax(np.median(np.abs(change) / usual, axis=1)))
    step = change[at]
    before, after = value[max(0, at + 1 - window) : at + 1], value[at + 1 : at + 1 + window]
    jumped = np.abs(step) > STEP * usual
    large = np.abs(step) > LEAST_SHARE * np.ptp(value, axis=0)
    if np.mean(jumped) <= MOST or not large.any() or min(len(before), len(after)) < window:
        return None
    # A foot that is put down hard may jump as far, but neither at once nor to where it stays.
    stays = np.median(after, axis=0) - np.median(before, axis=0)
    off = np.stack((stays - step, np.ptp(before[-NEAR:], axis=0), np.ptp(after[:NEAR], axis=0)))
    moves = np.ptp(value[at + 1 :], axis=0) > MOVES * usual
    if (np.abs(off) > STAYS * np.abs(step))[:, large].any() or not moves.any():
        return None
    if (np.abs(np.median(after[:NEAR], axis=0)) > ZERO * np.abs(step))[large].any():
        return None
    return float(time[at + 1])


def describe_zero_jumps(found: list[ZeroJump]) -> list[Finding]:
    """Zeros that are not one and the same within a run."""
    if not found:
        return []
    feet = sorted({one.foot for one in found})
    whose = "both feet" if len(feet) == len(FEET) else f"the {FEET[feet[0]]} foot"
    times = sorted({one.run: f"{one.time:.1f} s" for one in found}.items())
    listed = ", ".join(f"{time} of run {run}" for run, time in times)
    return [
        Finding(
            "FAIL",
            f"{name_runs([run for run, _ in times])}: the readings of {whose} jump all at once and "
            f"stay there (at {listed}): they were zeroed (tare) while the robot stood on them, or "
            "the board started again; zero them with both feet in the air, before the recording "
            "begins, and record again",
            Fault.MOVED_ZEROS,
        )
    ]
