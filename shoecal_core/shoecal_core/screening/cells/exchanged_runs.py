"""Runs in which left and right are exchanged, though they are not in the others.

Gains belong to the cells, not to the plugs: with the readings of a stretch of runs exchanged, one
set of gains fits all runs. What is exchanged in all of them is a matter of `wiring`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.screening.cells.wiring import BETTER, CLEAR_SHARE, exchanged, of_feet
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, moments_off, solve_sums
from shoecal_core.screening.verdict import Finding, name_runs


@dataclass(frozen=True)
class ExchangedRuns:
    """Runs with left and right exchanged.

    Attributes:
        runs: their numbers.
        off, left: how far these runs' CoP is off its model as it is, and exchanged (RMS) [m].
    """

    runs: tuple[int, ...]
    off: float
    left: float


def exchanged_runs(statics: Statics) -> ExchangedRuns | None:
    """The stretch of runs in which left and right are exchanged; None without."""
    pairs, numbers = of_feet(statics.shoe), list(statics.parts)
    if len(numbers) < 2 or not pairs:
        return None
    place = exchanged(np.arange(len(statics.shoe.names)), pairs)
    turned = statics.changed(lambda one: replace(one, readings=one.readings[:, place]))
    sums = {run: (statics.rows[run].sums(), turned.rows[run].sums()) for run in numbers}
    fits = {
        group: solve_sums([sums[run][run in group] for run in numbers], statics.information)
        for group in _groups(numbers)
    }
    best = min(fits, key=lambda group: fits[group].cost)
    now, then = fits[()].cost, fits[best].cost
    # Exchanged in all runs it is one fault of the cables.
    if not best or best == tuple(numbers) or then > min(CLEAR_SHARE * now, now - BETTER):
        return None
    off, left = (
        statics.settings.cop_std_m * moments_off([one.rows[run] for run in best], fits[best].vector)
        for one in (statics, turned)
    )
    return ExchangedRuns(best, off, left)


def _groups(numbers: Sequence[int]) -> list[tuple[int, ...]]:
    """No run, and every stretch of runs that follow each other."""
    count = len(numbers)
    return [()] + [
        tuple(numbers[first:end]) for first in range(count) for end in range(first + 1, count + 1)
    ]


def describe_exchanged_runs(found: ExchangedRuns | None) -> list[Finding]:
    """Runs with left and right exchanged."""
    if found is None:
        return []
    one = len(found.runs) == 1
    return [
        Finding(
            "FAIL",
            f"{name_runs(found.runs)}: left and right are exchanged, though not in the other "
            f"runs: the CoP is {1e3 * found.off:.0f} mm off its model as it is, "
            f"{1e3 * found.left:.0f} mm with the feet exchanged; put the plugs back or exchange "
            f"the channels' names in {'that run' if one else 'those runs'}, or leave "
            f"{'it' if one else 'them'} out (--train)",
            Fault.SWAPPED,
        )
    ]
