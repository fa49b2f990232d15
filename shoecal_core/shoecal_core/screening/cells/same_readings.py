"""Channels that read the same: a multiplexer or a driver that reads one of them twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

SAME_SHARE = 0.99
"""Of the samples that a session has of both, in which two channels agree to the last digit."""
LEAST_VALUES = 20
"""Different readings of a channel, at least: channels that stand still agree by chance."""


def same_readings(runs: Mapping[int, Run]) -> list[tuple[int, int]]:
    """Pairs of channels, by index, that have the same readings in all runs."""
    value = np.concatenate([run.readings.value for run in runs.values()])
    found = []
    for one, other in combinations(range(value.shape[1]), 2):
        known = value[np.isfinite(value[:, [one, other]]).all(axis=1)]
        same = int(np.count_nonzero(known[:, one] == known[:, other]))
        if same > SAME_SHARE * len(known) and len(np.unique(known[:, one])) >= LEAST_VALUES:
            found.append((one, other))
    return found


def describe_same_readings(shoe: Shoe, found: Sequence[tuple[int, int]]) -> list[Finding]:
    """Channels that are one."""
    return [
        Finding(
            "FAIL",
            f"{shoe.names[one]} and {shoe.names[other]} read the same, to the last digit: one of "
            "the two is read twice and the other never; check the multiplexer's address lines, "
            "the driver's list of channels, and the columns or indices of an import",
            Fault.TWINS,
        )
        for one, other in found
    ]
