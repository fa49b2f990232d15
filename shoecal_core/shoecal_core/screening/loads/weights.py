"""Was a run recorded under another weight: with a load in the hands, or while it was held?

Each run's forces are computed with gains and offsets fitted to the other runs alone. An error that
all runs have in common looks like wrong gains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.verdict import Finding

OFF_STDS = 4.0
"""A run's weight is wrong when it is this many of the settings' standard deviations off, beyond
what the other runs leave open."""
OPEN_STDS = 3.0
TARED_SHARE = 0.2
"""Of the weight: a sensor that was zeroed under its foot's load hides about half, hands that hold a
robot seldom so much."""


@dataclass(frozen=True)
class WrongWeight:
    """A run under another weight than the others.

    Attributes:
        run: its number.
        excess: measured less expected force [N].
        limit: up to which it could have been chance [N].
        undecided: it is this run or the other one that is reported.
    """

    run: int
    excess: float
    limit: float
    undecided: bool = False


def wrong_weights(statics: Statics) -> list[WrongWeight]:
    """Runs that do not agree with the others, the worst first, as long as most do agree.

    Two runs that do not agree are both returned: which of them is right is unknown.
    """
    kept, found = statics, list[WrongWeight]()
    while len(kept.parts) > 1:
        excesses = [_excess(run, kept) for run in kept.parts]
        worst = max(excesses, key=lambda one: abs(one.excess) / one.limit)
        if abs(worst.excess) <= worst.limit:
            break
        if len(kept.parts) == 2:
            return found + [replace(one, undecided=True) for one in excesses]
        found.append(worst)
        kept = kept.without({worst.run})
    return found


def _excess(run: int, runs: Statics) -> WrongWeight:
    fit, std = runs.without({run}).fit, runs.settings.force_std_n
    excess = float(np.median(runs.force_error(run, fit.vector)))
    # The rows of the force, in newtons.
    typical = std * np.median(runs.rows[run].matrix[0], axis=0)
    left_open = float(np.sqrt(typical @ fit.covariance @ typical))
    return WrongWeight(run, excess, OFF_STDS * std + OPEN_STDS * left_open)


def describe_weights(found: Sequence[WrongWeight], weight: float) -> list[Finding]:
    """Runs under another weight than that of robot and shoes [N]; the last two together when it is
    unknown which is right.
    """
    if len(found) > 1 and found[-1].undecided:
        one, other = found[-2:]
        apart = (abs(one.excess) + abs(other.excess)) / 2.0
        undecided = [
            Finding(
                "FAIL",
                f"runs {one.run} and {other.run} were recorded under weights {apart:.1f} N apart "
                "and no third run shows which is right: see that the robot carries nothing and is "
                "not held, then record again",
                Fault.WRONG_WEIGHT,
            )
        ]
        return describe_weights(found[:-2], weight) + undecided
    return [
        Finding(
            "WARN",
            f"run {one.run} was recorded with {abs(one.excess):.1f} N "
            f"{'more' if one.excess > 0.0 else 'less'} on the feet than the others (limit "
            f"{one.limit:.1f} N) and is left out: see that the robot carries nothing and is not "
            f"held, {_or_zeros(one, weight)}, then record it again",
            Fault.WRONG_WEIGHT,
        )
        for one in found
    ]


def _or_zeros(one: WrongWeight, weight: float) -> str:
    """What else looks so: zeros that moved, or that hide much of the weight [N]."""
    if one.excess < -TARED_SHARE * weight:
        return "and that no sensor is zeroed (tare, bias) while its foot carries load"
    return "and that nothing was zeroed or switched on again before it"
