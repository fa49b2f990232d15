"""A cell whose zero wanders from run to run or within them: wet, overloaded, or loosely connected.

Each run's equations get a zero of one channel of its own, and a drift of it:

    sum_i A_i (g_i S_i + d_i) + A_k (z_r + v_r t) = w - b

for every channel k in turn. The one whose wandering explains what the runs contradict each other
and themselves by, and no other one nearly as well, is named.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, solve
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

LEFT = 0.2
"""Of the misfit, that the wandering of one channel may leave."""
KEPT = 0.2
"""Of how far the zero wanders, what it does within any run where it keeps it there."""
NEXT = 2.0
"""Times what it leaves, that the wandering of any other leaves at least."""
LEAST_SHARE = 0.03
"""Part of the weight by which the zero has to wander: less is left to the joint fit."""


@dataclass(frozen=True)
class Wandering:
    """A channel whose zero does not stay.

    Attributes:
        channel: index.
        force: between its least and its largest zero [N].
        kept: it stays within each run.
    """

    channel: int
    force: float
    kept: bool


def wandering(statics: Statics) -> Wandering | None:
    """The one-axis cell whose zero wanders; None where none does."""
    none, weight = statics.fit.cost, statics.weight
    cells = [k for k, one in enumerate(statics.shoe.channels) if one.column[0] == 1.0]
    found = [(*_with_own(channel, statics), channel) for channel in cells]
    if len(found) < 2:
        return None
    (best, force, within, channel), (second, *_) = sorted(found)[:2]
    least = max(LEAST_SHARE * weight, statics.settings.force_std_n)
    if force < least or best > LEFT * none or second < NEXT * best:
        return None
    # One run under a load at a cell's corner looks like another zero of it: that run is left out.
    if min(_loaded(run, statics) for run in statics.parts) < best:
        return None
    return Wandering(channel, force, within < KEPT * force)


def _loaded(run: int, statics: Statics) -> float:
    """The misfit with a constant load anywhere in one run."""
    loaded = {
        other: one.with_columns(
            np.broadcast_to(np.eye(3)[:, None] * (other == run), (3, one.matrix.shape[1], 3))
        )
        for other, one in statics.robust.items()
    }
    load = np.full(3, statics.weight**-2.0)
    return solve(loaded, np.concatenate((statics.information, load))).cost


def _with_own(channel: int, statics: Statics) -> tuple[float, float, float]:
    """The misfit with zeros and drifts of one channel, how far its zero then wanders, and how far
    within a run [N].
    """
    runs, parts, information = statics.robust, statics.parts, statics.information
    count, own = 2 * len(runs), {}
    changes: dict[int, FloatArray] = {}
    for at, (run, one) in enumerate(runs.items()):
        time = parts[run].time - parts[run].time[0]
        courses = np.stack((np.ones(len(time)), time / max(float(time[-1]), 1e-9)), axis=1)
        column = one.matrix[:, :, len(information) // 2 + channel, None]
        columns = np.zeros((3, len(time), count))
        columns[:, :, 2 * at : 2 * at + 2] = column * courses
        own[run] = one.with_columns(columns)
        changes[run] = courses
    fit = solve(own, np.concatenate((information, np.full(count, statics.weight**-2.0))))
    extra = fit.vector[len(information) :].reshape(len(runs), 2)
    course = np.concatenate([changes[run] @ mine for run, mine in zip(runs, extra, strict=True)])
    return fit.cost, float(np.ptp(course)), float(np.abs(extra[:, 1]).max())


def describe_wandering(shoe: Shoe, found: Wandering) -> list[Finding]:
    """A cell whose zero does not stay."""
    name = shoe.names[found.channel]
    if found.kept:
        text = (
            f"{name} has another zero in each run, by up to {found.force:.1f} N, and keeps it "
            "there: zeroed (tare) or switched on before each run, or its cable was moved; take "
            "tare() out of the firmware, leave the power on, and record again"
        )
    else:
        text = (
            f"the zero of {name} wanders by {found.force:.1f} N between and within the runs: look "
            "for water, a loose cable, a board that was just switched on, or a cell that was "
            "overloaded, and record again"
        )
    return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
