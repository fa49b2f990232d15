"""Cells of a rigid sole keep to a plane: with four and more, each follows from the others.

    sum_i p_i (g_i S_i + d_i) = 0        for some p, whatever the robot does

One plane for all runs is compared with one for a stretch of runs and another for all others, each
with zeros of its own. That shows cells that answer otherwise in some runs by far less than the
vertical force does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.changed_gains import LEAST_RUNS, groups
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import FEET

PLANE = 3
"""Cells that any forces suit."""
LEFT = 0.3
"""Of how far the cells are off one plane (RMS), what two leave at most: 0.08 where two cells of a
board read 7 % less, 0.91 and more in sound sessions and where a cell touches its shell."""
LEAST_SHARE = 0.0005
"""Of the weight, that the cells are off one plane at least. Sound simulated ones are by 0.00015,
two cells that read 7 % less by 0.0014, which moved the CoP of that foot by 3 mm."""


@dataclass(frozen=True)
class ChangedPlane:
    """A foot whose cells answer otherwise in some runs.

    Attributes:
        foot: index into FEET.
        runs, rest: their numbers.
        off: from one plane for all (RMS) [N].
    """

    foot: int
    runs: tuple[int, ...]
    rest: tuple[int, ...]
    off: float


def cell_forces(statics: Statics, foot: int) -> dict[int, FloatArray]:
    """(B, k) by run, forces of a foot's vertical cells, without zeros; empty for too few [N]."""
    own = statics.shoe.of_foot(foot)
    own = own[statics.shoe.vertical[own]]
    if len(own) <= PLANE:
        return {}
    gain = statics.fit.parameters.gain[own]
    return {run: one.readings[:, own] * gain for run, one in statics.parts.items()}


def off_plane(force: FloatArray) -> tuple[float, FloatArray]:
    """Sum of squares that forces (B, k) are off their best plane, and what is across it (k,)."""
    _, spreads, directions = np.linalg.svd(force - force.mean(axis=0), full_matrices=False)
    return float(spreads[-1] ** 2), np.asarray(directions[-1])


def changed_plane(statics: Statics) -> ChangedPlane | None:
    """The foot whose cells keep to two planes instead of one; None without."""
    if len(statics.parts) < LEAST_RUNS:
        return None
    found = [
        one
        for foot in range(len(FEET))
        if (one := _changed(foot, cell_forces(statics, foot), statics.weight)) is not None
    ]
    return max(found, key=lambda one: one.off, default=None)


def _changed(foot: int, force: Mapping[int, FloatArray], weight: float) -> ChangedPlane | None:
    if not force:
        return None

    def square(runs: tuple[int, ...]) -> float:
        return off_plane(np.concatenate([force[run] for run in runs]))[0]

    numbers = tuple(force)
    rest = {group: tuple(run for run in numbers if run not in group) for group in groups(numbers)}
    left, best = min((square(group) + square(others), group) for group, others in rest.items())
    whole = square(numbers)
    off = float(np.sqrt(whole / sum(map(len, force.values()))))
    if left > LEFT**2 * whole or off < LEAST_SHARE * weight:
        return None
    return ChangedPlane(foot, best, rest[best], off)


def describe_changed_plane(found: ChangedPlane | None) -> list[Finding]:
    """Cells that answer otherwise in some runs."""
    if found is None:
        return []
    return [
        Finding(
            "WARN",
            f"cells of the {FEET[found.foot]} foot answer otherwise in {name_runs(found.runs)} "
            f"than in {name_runs(found.rest)}: they are off one plane by {found.off:.2f} N (RMS), "
            "and each part keeps to its own; see whether a cell or board was exchanged, set to "
            "another range, or its screw tightened, and calibrate these runs on their own "
            "(--train)",
            Fault.CHANGED_GAINS,
        )
    ]
