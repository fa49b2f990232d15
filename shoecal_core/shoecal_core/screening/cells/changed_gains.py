"""Were some runs recorded under other gains: another amplifier range, other cells or shoes?

One set of gains for all runs is compared with two: one for a stretch of runs and one for all
others. The runs' own zeros are free both times, so that a tare between runs is no change of gains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.zeros import LEAST_COST, with_own
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import NormalEquations, RoughFit, Statics, solve_sums
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import FEET, Shoe

LEFT = 0.2
"""Of the misfit under common gains, what two sets of gains leave at most. Wrong weights, ropes and
slips are no gains: they leave more."""
LEAST_RUNS = 3
"""Of two runs it is not known which is the odd one."""
DIFFERS = 0.08
"""By which a gain differs from the other one's, as a share: gains are known no better from a few
runs; amplifiers' ranges differ by a factor of two and more, cells of one type by a quarter."""
DIFFERS_STDS = 4.0
"""The same in standard deviations."""
LARGEST = 10.0
"""Ratio of gains of one channel: amplifiers' ranges are at most a factor of eight apart. What needs
more, or another sign, is a foot that hung or was held, which gains of their own take up."""
ALIKE, ALIKE_SHARE = 0.05, 0.15
"""Standard deviation of ratios' logarithms, and its part of their mean, up to which they are one
change of all these channels: ratios are known to about 5 %, those of cells differ by their size."""


@dataclass(frozen=True)
class ChangedGains:
    """Runs with other gains than the rest.

    Attributes:
        runs, rest: their numbers.
        ratio: by channel, its gain [N per unit of its readings] in `runs` over that in `rest`;
            those that stay are left out.
    """

    runs: tuple[int, ...]
    rest: tuple[int, ...]
    ratio: Mapping[int, float]


def changed_gains(statics: Statics) -> ChangedGains | None:
    """Whether gains of a stretch of runs are not those of all others.

    Returns:
        None where they are, or where all of them changed by one factor, which is another weight.
    """
    numbers, information = list(statics.parts), statics.information
    if len(numbers) < LEAST_RUNS:
        return None
    own, whole = with_own(statics, numbers)
    sums = {run: one.sums() for run, one in own.items()}
    common = max(solve_sums(list(sums.values()), whole).cost, LEAST_COST)
    fits = {group: _apart(sums, group, information, whole) for group in groups(numbers)}
    best = min(fits, key=lambda group: fits[group].cost)
    if fits[best].cost > LEFT * common:
        return None
    ratio = _ratios(fits[best], len(information) // 2)
    if any(not 1.0 / LARGEST < one < LARGEST for one in ratio.values()):
        return None
    if not ratio or (2 * len(ratio) == len(information) and _alike(ratio)):
        return None
    return ChangedGains(best, tuple(run for run in numbers if run not in best), ratio)


def groups(numbers: Sequence[int]) -> list[tuple[int, ...]]:
    """Runs that follow each other, no more than half of all; of two halves the later one."""
    count = len(numbers)
    return [
        tuple(numbers[first:end])
        for first in range(count)
        for end in range(first + 1, count + 1)
        if 2 * (end - first) < count or (2 * (end - first) == count and first)
    ]


def _apart(
    sums: Mapping[int, NormalEquations],
    group: Sequence[int],
    information: FloatArray,
    whole: FloatArray,
) -> RoughFit:
    """Gains and offsets of the others, own zeros, and by how much the group's ones differ."""
    both = np.eye(len(whole), len(whole) + len(information))
    both[: len(information), len(whole) :] = np.eye(len(information))
    rest = np.eye(*both.shape)
    return solve_sums(
        [
            NormalEquations(turn.T @ one.product @ turn, turn.T @ one.right, one.square, one.count)
            for run, one in sums.items()
            for turn in (both if run in group else rest,)
        ],
        np.concatenate((whole, information)),
    )


def _ratios(fit: RoughFit, count: int) -> dict[int, float]:
    """Of each channel whose gain changed."""
    first, more = np.arange(count), len(fit.vector) - 2 * count + np.arange(count)
    gain, change = fit.vector[first], fit.vector[more]
    ratio = 1.0 + change / gain
    # Of a ratio of two estimates, to first order.
    slope = np.stack((-change / gain**2, 1.0 / gain))
    rows = np.stack((first, more))
    covariance = fit.covariance[rows[:, None], rows[None, :]]
    std = np.sqrt(np.einsum("ic,ijc,jc->c", slope, covariance, slope))
    off = np.abs(ratio - 1.0)
    return {
        int(channel): float(ratio[channel])
        for channel in np.flatnonzero((off > DIFFERS) & (off > DIFFERS_STDS * std))
    }


def _alike(ratio: Mapping[int, float]) -> bool:
    """Whether all are one change."""
    values = np.array(list(ratio.values()))
    if values.min() <= 0.0:
        return False
    change = np.log(values)
    return bool(np.std(change) < max(ALIKE, ALIKE_SHARE * abs(change.mean())))


def describe_changed_gains(shoe: Shoe, found: ChangedGains) -> list[Finding]:
    """Runs under other gains; their readings are so many times as large as gains are small."""
    feet = [
        name
        for foot, name in enumerate(FEET)
        if set(found.ratio) == set(shoe.of_foot(foot)) and _alike(found.ratio)
    ]
    times = 1.0 / float(np.mean(list(found.ratio.values())))
    where = f"in {name_runs(found.runs)}"
    if feet:
        text = (
            f"all readings of the {feet[0]} foot are {times:.2f} times as large {where} as in the "
            "others: its amplifier had another gain or its cells another supply; set one for all "
            "runs and record again, or calibrate these runs on their own (--train)"
        )
    elif len(found.ratio) == 1:
        (channel,) = found.ratio
        text = (
            f"{shoe.names[channel]} reads {times:.2f} times as much {where} as in the others: "
            "see what was changed at its amplifier, supply and cable, then record again, or leave "
            "these runs out"
        )
    else:
        most = sorted(found.ratio, key=lambda one: -abs(np.log(abs(found.ratio[one]))))[:3]
        shown = ", ".join(f"{shoe.names[one]} {1.0 / found.ratio[one]:.2f}" for one in most)
        text = (
            f"the cells answer otherwise {where} than in the others (times as much: {shown}): "
            "were other shoes worn, or cells exchanged? Calibrate each pair of shoes from its own "
            "runs (--train)"
        )
    return [Finding("FAIL", text, Fault.CHANGED_GAINS)]
