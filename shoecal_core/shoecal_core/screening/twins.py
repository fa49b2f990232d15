"""Runs that hold the same readings: one recording was named twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

LEAST_S = 1.0
"""Shorter pieces that are the same say nothing: coarse readings of a robot at rest repeat."""
LEAST_VALUES = 20
"""Different readings of the most varied channel in the piece, at least, for the same reason."""


@dataclass(frozen=True)
class Twins:
    """Two runs with the same readings.

    Attributes:
        runs: both numbers.
        seconds: of them that are the same.
    """

    runs: tuple[int, int]
    seconds: float


def find_twins(runs: Mapping[int, Run]) -> list[Twins]:
    """Every pair of runs of which one holds a piece of the other, be it all of it."""
    found = []
    for first, second in combinations(runs, 2):
        values = runs[first].readings.value, runs[second].readings.value
        count = max(_shared(*values), _shared(*reversed(values)))
        time = runs[first].readings.time
        seconds = count * float(np.median(np.diff(time))) if count else 0.0
        if seconds >= LEAST_S:
            found.append(Twins((first, second), seconds))
    return found


def _shared(one: FloatArray, other: FloatArray) -> int:
    """Samples that the end of readings (T, n) shares with the beginning of others (S, n)."""
    if not len(one) or not len(other):
        return 0
    for start in np.flatnonzero((one == other[0]).all(axis=1)).tolist():
        count = min(len(one) - start, len(other))
        piece = other[:count]
        varied = max(len(np.unique(channel)) for channel in piece.T)
        if varied >= LEAST_VALUES and np.array_equal(one[start : start + count], piece):
            return count
    return 0


def describe_twins(found: Sequence[Twins]) -> list[Finding]:
    """Recordings that were named twice."""
    return [
        Finding(
            "FAIL",
            f"runs {one.runs[0]} and {one.runs[1]} hold the same readings ({one.seconds:.1f} s of "
            "them): what is fitted to one is no test on the other; give each trial a recording of "
            "its own",
            Fault.TWINS,
        )
        for one in found
    ]
