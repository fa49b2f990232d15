"""Do both feet stand where they stood? Checked by the pose of one sole in the other's frame.

Play and compliance let that wander a little. A foot that slipped shows as a step that stays, at a
moment at which the load on the cells steps too.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.ndimage import maximum_filter1d

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import evenly, typical_period
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

Key = TypeVar("Key", bound=Hashable)

PLACE = [0, 1, 5]
"""Of a pose: where the right foot stands."""
GAP_S, WINDOW_S = 0.5, 1.0
"""A step is the mean of one window after a gap less that of one before it."""
LOAD_GAP_S, LOAD_WINDOW_S = 0.3, 0.5
"""The same for the readings, which change faster; both windows then have one common slope."""
CLOSURE_STEP, LOAD_STEP, BOTH_STEPS = 4.0, 10.0, 105.0
"""A slip's steps, in standard deviations of the steps that the session otherwise has: each at
least, and their product."""
LEAST_M, LEAST_RAD, LEAST_SHARE = 5e-5, 5e-4, 1e-3
"""Added to those standard deviations: a robot without play, or one that hardly moves, is no
reason for alarm. The last is a share of a channel's whole range."""
HARMLESS_STDS = 2.0
"""A smaller step is no slip, in standard deviations of what the fit allows each run's support."""
USUAL = 0.98
"""Part of a session's steps that are usual."""
ENOUGH = 50_000
"""Samples from which that is taken."""


@dataclass(frozen=True)
class FootMotion:
    """One run's samples at which both feet are on the floor.

    Attributes:
        time: (T,) since the run's start [s].
        pose: (T, 6) of the right sole in the left's frame: x, y, z, tilts about x and y, yaw.
        readings: (T, n) raw.
    """

    time: FloatArray
    pose: FloatArray
    readings: FloatArray


@dataclass(frozen=True)
class Slipped:
    """A step of one foot against the other.

    Attributes:
        time: since the run's start [s].
        shift: (3,) its size by the joint angles: dx, dy [m], dtheta [rad].
    """

    time: float
    shift: FloatArray


def feet(aligned: Aligned, readings: FloatArray, standing: BoolArray) -> FootMotion:
    """What `slips` needs of a run.

    Args:
        aligned: T samples.
        readings: (T, n) in place of the recorded ones.
        standing: (T,) samples to take.
    """
    pose = aligned.states.right_sole
    return FootMotion(aligned.time[standing], pose[standing], readings[standing])


def slips(runs: Mapping[Key, FootMotion]) -> dict[Key, Slipped]:
    """The first slip of every run, or part of one, that has one."""
    runs = {run: one for run, one in runs.items() if len(one.time) > 1}
    if not runs:
        return {}
    closure = {run: _steps(one.pose, one.time) for run, one in runs.items()}
    closure_size = _in_usual(closure, np.array([LEAST_M] * 3 + [LEAST_RAD] * 3))
    load = {run: _kinks(one.readings, one.time) for run, one in runs.items()}
    allowed = Tolerances()
    harmless = np.diag([allowed.support_m, allowed.support_m, allowed.support_rad]) ** 2
    low = np.min([one.readings.min(axis=0) for one in runs.values()], axis=0)
    high = np.max([one.readings.max(axis=0) for one in runs.values()], axis=0)
    load_size = _in_usual(load, LEAST_SHARE * (high - low))
    found = {}
    for run, one in runs.items():
        period = typical_period(one.time)
        near = maximum_filter1d(load_size[run], 2 * round(GAP_S / 2.0 / period) + 1)
        here = (closure_size[run] > CLOSURE_STEP) & (near > LOAD_STEP)
        here &= closure_size[run] * near > BOTH_STEPS
        here &= _lengths(closure[run][:, PLACE], np.linalg.inv(harmless)) > HARMLESS_STDS
        if here.any():
            first = int(np.argmax(here))
            reach = round((GAP_S + WINDOW_S) / period)
            at = first + int(np.argmax(closure_size[run][first : first + reach]))
            found[run] = Slipped(float(one.time[at]), closure[run][at, PLACE])
    return found


def _in_usual(steps: Mapping[Key, FloatArray], least: FloatArray) -> dict[Key, FloatArray]:
    """(T,) length of each run's steps (T, k), in the session's usual standard deviations."""
    stride = 1 + sum(map(len, steps.values())) // ENOUGH
    some = np.concatenate([one[::stride] for one in steps.values()])
    length = np.zeros(len(some))
    for _ in range(3):
        usual = some[length <= np.quantile(length, USUAL)]
        inverse = np.linalg.inv(usual.T @ usual / len(usual) + np.diag(least**2))
        length = _lengths(some, inverse)
    return {run: _lengths(one, inverse) for run, one in steps.items()}


def _lengths(steps: FloatArray, inverse: FloatArray) -> FloatArray:
    lengths: FloatArray = np.sqrt(np.einsum("ti,ti->t", steps @ inverse, steps))
    return lengths


def _steps(values: FloatArray, time: FloatArray) -> FloatArray:
    """(T, k) mean after each instant less mean before it; 0 where a window does not fit."""
    return evenly(_even_steps, values, time)


def _even_steps(values: FloatArray, period: float) -> FloatArray:
    gap, size = round(GAP_S / 2.0 / period), max(1, round(WINDOW_S / period))
    sums = np.concatenate((np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)))
    steps = np.zeros_like(values)
    at = np.arange(gap + size, len(values) - gap - size)
    after = sums[at + gap + size] - sums[at + gap]
    before = sums[at - gap] - sums[at - gap - size]
    steps[at] = (after - before) / size
    return steps


def _kinks(values: FloatArray, time: FloatArray) -> FloatArray:
    """(T, k) steps over and above one slope through both windows; 0 where they do not fit."""
    return evenly(_even_kinks, values, time)


def _even_kinks(values: FloatArray, period: float) -> FloatArray:
    gap, size = round(LOAD_GAP_S / 2.0 / period), max(2, round(LOAD_WINDOW_S / period))
    side = np.arange(gap + 1, gap + size + 1, dtype=np.float64)
    places = np.concatenate((-side[::-1], side))
    rows = np.stack((np.ones_like(places), places, (places > 0.0).astype(float)), axis=1)
    weights = np.zeros(2 * (gap + size) + 1)
    weights[(places + gap + size).astype(int)] = np.linalg.pinv(rows)[2]
    kinks = np.zeros_like(values)
    reach = gap + size
    if len(values) > 2 * reach:
        for column in range(values.shape[1]):
            kinks[reach : len(values) - reach, column] = np.convolve(
                values[:, column], weights[::-1], "valid"
            )
    return kinks


def describe_slips(slips: Mapping[int, Slipped]) -> list[Finding]:
    """Feet that slipped."""
    return [
        Finding(
            "WARN",
            f"a foot slipped in run {run} at {slip.time:.1f} s (by the joint angles, "
            f"{1e3 * np.linalg.norm(slip.shift[:2]):.1f} mm and {np.degrees(slip.shift[2]):.1f} "
            "deg): where it came to rest is not known, so what came after is left out; record the "
            "run again",
            Fault.SLIPPED,
        )
        for run, slip in slips.items()
    ]
