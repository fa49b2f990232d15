"""Was the robot pulled or pressed for a while: by a rope, a hand, or a cable?

While it only leans, its feet carry the weight at every moment. Each run's vertical force is
computed with gains and offsets fitted to the other runs alone: fitted to the run itself, they
follow the pull. What differs all along a run is another weight (`weights`), what is over at once a
push (`disturbed`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.stretches import Stretch, lasting, list_stretches, stretches
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.weights import OFF_STDS, OPEN_STDS
from shoecal_core.screening.rough_fit import Statics, solve
from shoecal_core.screening.verdict import Finding, name_runs

LASTS_S = 2.0
"""What is over sooner is no pull; the force is smoothed over half of it."""
LEAST_SHARE = 0.02
"""Part of the weight from which a force counts."""
CONTRADICTS = 2.0
"""A run that is pulled contradicts itself by so many times as much as others do: no gains and
offsets of its own make up for the pull, as they would for another weight."""
WAVERS_SHARE = 0.01
"""Part of the weight by which the vertical force of a run may be off under gains and offsets of its
own (RMS). Healthy simulated robots and a real iCub leave 0.1 %, 3 % of ripple in the cells' supply
leaves 2 %."""
JOIN_S = 3.0
"""Pulls no farther apart than this are reported as one: a rope slackens and tightens."""


@dataclass(frozen=True)
class Pull:
    """A force from outside on one run.

    Attributes:
        run: its number.
        force: where it is largest, positive downwards [N].
        stretches: when, since the run's start [s].
        undecided: there is only one other run to see it by.
        sideways: it acts along the floor.
    """

    run: int
    force: float
    stretches: tuple[Stretch, ...]
    undecided: bool = False
    sideways: bool = False

    @property
    def acted(self) -> str:
        """What it did, in words."""
        if self.sideways:
            return "pushed the robot sideways"
        return "pressed the robot down" if self.force > 0.0 else "held the robot up"


@dataclass(frozen=True)
class Wavering:
    """A vertical force that no gains and offsets make constant, in most of the runs.

    Attributes:
        runs: their numbers.
        force: by how much it varies in the worst (95 % of its samples) [N].
    """

    runs: tuple[int, ...]
    force: float


def wavering(statics: Statics, watched: Collection[int]) -> Wavering | None:
    """Runs that contradict themselves, where most that are watched do: no other shows the pull.

    It comes before cables are looked at: exchanged cells and turned signs take some of it.

    Args:
        watched: as that of `pulls`.
    """
    off = {run: _off(run, statics) for run in statics.parts}
    most = WAVERS_SHARE * statics.weight
    # What cells tremble by is no force on the robot.
    so = [
        run
        for run, force in off.items()
        if (force**2).mean() - statics.trembling(run) ** 2 > most**2
    ]
    if not 2 * len(set(so) & set(watched)) > len(watched):
        return None
    spans = [float(np.ptp(np.quantile(off[run], (0.025, 0.975)))) for run in so]
    return Wavering(tuple(so), max(spans))


def pulls(statics: Statics, watched: Collection[int]) -> list[Pull]:
    """Runs with a force from outside, the worst first, as long as others are there to see it by.

    Args:
        watched: runs that keep both feet on the floor and move slowly.
    """
    kept, found = statics, list[Pull]()
    alone = {run: _misfit(run, statics) for run in statics.parts}
    while len(kept.parts) > 1:
        seen = [_pull(run, kept) for run in kept.parts]
        pulled = [one for one in seen if one is not None and one.run in watched]
        if not pulled:
            break
        # A run that is pulled spoils what is said of the others, but by themselves they fit.
        worst = max(pulled, key=lambda one: alone[one.run])
        others = [alone[run] for run in kept.parts if run != worst.run]
        if alone[worst.run] < CONTRADICTS * float(np.median(others)):
            break
        found.append(replace(worst, undecided=len(kept.parts) == 2))
        kept = kept.without({worst.run})
    return found


def what_lasts(force: FloatArray, period: float) -> FloatArray:
    """(B, k) forces without what is over soon, of blocks so far apart [s]."""
    size = 2 * max(1, round(LASTS_S / 4.0 / period)) + 1
    left: FloatArray = median_filter(force, (size, 1), mode="nearest")
    return left


def _misfit(run: int, runs: Statics) -> float:
    """RMS of what the run's own gains and offsets leave of its vertical force [N]."""
    return float(np.sqrt((_off(run, runs) ** 2).mean()))


def _off(run: int, runs: Statics) -> FloatArray:
    """(B,) what the run's own gains and offsets leave of its vertical force [N]."""
    own = solve({run: runs.rows[run]}, runs.information)
    return runs.force_error(run, own.vector)


def _pull(run: int, runs: Statics) -> Pull | None:
    fit, part, std = runs.without({run}).fit, runs.parts[run], runs.settings.force_std_n
    force = what_lasts(runs.force_error(run, fit.vector)[:, None], part.period)[:, 0]
    rows = std * runs.rows[run].matrix[0]
    left_open = np.sqrt(np.einsum("bi,ij,bj->b", rows, fit.covariance, rows))
    limit = max(OFF_STDS * std, LEAST_SHARE * runs.weight) + OPEN_STDS * left_open
    beyond = lasting(np.abs(force) > limit, part.time, LASTS_S)
    steady = float(np.ptp(np.quantile(force, [0.02, 0.98]))) < float(np.median(limit))
    if not beyond.any() or steady:
        return None
    at = int(np.argmax(np.abs(force) * beyond))
    return Pull(run, float(force[at]), stretches(beyond, part.time, JOIN_S))


def describe_wavering(found: Wavering) -> list[Finding]:
    """A vertical force that varies in most runs."""
    vary = "vary" if found.runs[1:] else "varies"
    return [
        Finding(
            "FAIL",
            f"the vertical forces of {name_runs(found.runs)} {vary} by up to {found.force:.1f} N "
            "while the robot only leans, whatever the cells' gains and zeros are: take off the "
            "rope or cable, do not touch the robot, see that the cells' supply voltage is steady, "
            "and record again",
            Fault.PULLED,
        )
    ]


def describe_pulls(found: Sequence[Pull]) -> list[Finding]:
    """Forces from outside; with one other run alone, nothing else can be checked."""
    return [
        Finding(
            "FAIL" if one.undecided else "WARN",
            f"run {one.run}: a force from outside of up to {abs(one.force):.1f} N "
            f"{one.acted} ({list_stretches(one.stretches)}), while it only leant"
            f"{'' if one.undecided else ', left out'}: take off the rope or cable, do not "
            "touch the robot, and record the run again"
            f"{'' if one.undecided else ', or leave it out (--train)'}",
            Fault.PULLED,
        )
        for one in found
    ]
