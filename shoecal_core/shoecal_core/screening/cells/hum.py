"""A steady oscillation in the readings that the motion does not make, as hum of the mains does.

Hum of 50 or 60 Hz that is sampled without a low-pass shows as a slow wave, whose frequency is that
of the hum less a multiple of the rate. It is sought in what the vertical force differs from the
weight by: one frequency that makes up most of it in every run. One that the modelled CoP has, too,
or of which it has a half or a third, comes from the motion.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.verdict import Finding

STEP_HZ, HIGHEST_HZ = 0.005, 2.4
"""Frequencies that are tried; the highest is that of two blocks."""
LEAST_PERIODS = 2.0
"""In the shortest run; slower waves are drifts."""
LEAST_RUNS = 3
"""In two runs a frequency may be the same by chance."""
SHARE, EACH_SHARE = 0.5, 0.3
"""Of the squares of the force's error, that one frequency has in the median run, and in each one:
with hum of 0.8 N on four cells 0.76 and 0.57; of sound simulated sessions at most 0.1, of iCub,
which moves by two sines, 0.31 and 0.08."""
MOTION_SHARE = 0.2
"""The same of the modelled CoP: from it in every run, the frequency is that of the motion."""
PARTS = np.array([1.0, 2.0, 3.0])
"""A motion makes its own frequency, and what is not linear the double and the triple of it."""
LEAST_STDS = 0.25
"""Amplitude from which it is reported, in the settings' standard deviations of the force."""


@dataclass(frozen=True)
class Hum:
    """An oscillation: its frequency [Hz] and its amplitude in the vertical force [N]."""

    frequency: float
    amplitude: float


def find_hum(statics: Statics, watched: Collection[int]) -> Hum | None:
    """The oscillation that all watched runs share; None without.

    Args:
        watched: runs in which both feet stand.
    """
    parts = statics.parts
    runs = [run for run in parts if run in watched]
    if len(runs) < LEAST_RUNS:
        return None
    lowest = LEAST_PERIODS / min(float(np.ptp(parts[run].time)) for run in runs)
    tried = np.arange(lowest, HIGHEST_HZ, STEP_HZ)
    force = [statics.force_error(run, statics.fit.vector)[:, None] for run in runs]
    times = [parts[run].time for run in runs]
    shares = np.array([_shares(t, y, tried) for t, y in zip(times, force, strict=True)])
    best = int(np.argmax(np.median(shares, axis=0)))
    there = shares[:, best]
    amplitude = np.median([np.sqrt(2.0 * s * y.var()) for s, y in zip(there, force, strict=True)])
    least = LEAST_STDS * statics.settings.force_std_n
    if np.median(there) < SHARE or there.min() < EACH_SHARE or amplitude < least:
        return None
    frequency = float(tried[best])
    motion = [_shares(parts[run].time, parts[run].cop, frequency / PARTS) for run in runs]
    if np.min(motion, axis=0).max() > MOTION_SHARE:
        return None
    return Hum(frequency, float(amplitude))


def _shares(time: FloatArray, values: FloatArray, frequencies: FloatArray) -> FloatArray:
    """(F,) part of the squares of values (T, k), their slow course taken away, at frequencies."""
    at = (time - time.mean()) / max(float(np.ptp(time)), 1e-9)
    slow = np.vander(at, 3)
    left = values - slow @ np.linalg.lstsq(slow, values, rcond=None)[0]
    found = np.empty(len(frequencies))
    for index, phase in enumerate(2.0 * np.pi * frequencies[:, None] * time):
        waves = np.stack((np.cos(phase), np.sin(phase)), axis=1)
        size, *_ = np.linalg.lstsq(waves, left, rcond=None)
        found[index] = ((waves @ size) ** 2).sum()
    return found / max(float((left**2).sum()), 1e-30)


def describe_hum(found: Hum | None) -> list[Finding]:
    """An oscillation that the motion does not make."""
    if found is None:
        return []
    return [
        Finding(
            "WARN",
            f"the readings oscillate at {found.frequency:.2f} Hz in all runs, by "
            f"{found.amplitude:.2f} N of the vertical force, whatever the robot does: hum of the "
            "mains (50 or 60 Hz, aliased) or another disturbance; shield the cables, ground the "
            "amplifier, set the converter's filter for the mains, and record again",
            Fault.HUM,
        )
    ]
