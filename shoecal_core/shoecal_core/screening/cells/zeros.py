"""Do the channels have other zeros in each run? Boards that tare when they get power do that.

Each run's equations get a wrench of its own, as if its zeros differed from the others' by it:

    sum_i A_i (g_i S_i + d_i) + b_r = w - b

One run's stances fix three numbers of its zeros, no more: so b_r (F, Mx, My), not each channel's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.screening.blocks import Blocks
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Equations, Statics, deviations, reweighed, solve
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import FEET, Shoe

LEAST_COST = 1.0
WHOLE = 0.1
"""Part of the weight by which a difference may miss all of it: gains are roughly known."""
SAME = 0.05
"""Part of the weight by which runs under the same weight may differ."""
TILT_RAD = 0.05
"""What errors of joints, floor and feet move the CoP by from run to run, as a tilt of the robot:
faults of joints and floors that were tried gave up to 0.03."""
PART, LEAST_RUNS = 0.2, 2
"""Part of the weight by which a tare of some cells sets runs apart, and runs on either side."""
LEFT = 0.2
"""Of what the runs contradict each other by, the most that zeros of their own may leave. Of a tare
they leave a hundredth; of other faults mostly all."""
NO_BETTER = 0.5
"""Of what is left, what zeros of a run that was not zeroed leave again at least."""

AT_ZERO = 0.05
"""Share of its range in a run by which each channel of a foot may start off zero after a tare."""
BOTH_AT_ZERO = 0.15
"""The same of the other foot, up to which it was zeroed, too."""
CHANNEL_AT_ZERO = 0.01
"""The same of a channel by itself, which chance brings there sooner than all of a foot."""
BEGIN_APART_M = 0.01
"""By which the CoP is elsewhere at the start of runs in other postures: what each cell carries
differs by a tenth and more then."""
BESIDES = 0.3
"""Of a run's own wrench, what those of channels that start at zero leave at most: a load is carried
elsewhere."""


@dataclass(frozen=True)
class MovedZeros:
    """Runs whose zeros differ from each other's.

    Attributes:
        less: runs that show less than others by the robot's weight, or `part`; mostly empty.
        reference: the runs that the others are compared with.
        cop: by run, what the zeros move the CoP by against the reference [m].
        part: that `less` show less, where it is only a part of the weight; 0: all of it [N].
        tared: by foot (index into FEET), the runs before which it alone was zeroed under load.
        channels: that start at zero in all runs of `less`, where no foot alone does.
    """

    less: tuple[int, ...]
    reference: tuple[int, ...]
    cop: Mapping[int, float]
    part: float = 0.0
    tared: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    channels: tuple[int, ...] = ()


def moved_zeros(statics: Statics, height: float) -> MovedZeros | None:
    """Whether zeros moved between runs by what only a tare under load moves them by.

    Args:
        height: of the CoM over the floor [m].

    Returns:
        None where they did not.
    """
    at_zero = starts(statics.parts)
    tared = starts_at_zero(statics.shoe, at_zero)
    shift, left, common = _shifts(statics)
    if left > LEFT:
        return None
    numbers, weight = list(statics.parts), statics.weight
    scale = np.array([1.0, TILT_RAD * height, TILT_RAD * height]) * weight
    away = np.linalg.norm((shift - np.median(shift, axis=0)) / scale, axis=1)
    at = int(np.argmin(away))
    # A tare of one foot hides what it carried, which is another load before each run.
    if tared and np.abs(shift / scale - (shift / scale)[at]).max() > PART:
        every = {run for one in tared.values() for run in one}
        rest = tuple(run for run in numbers if run not in every)
        return MovedZeros((), rest, {}, tared=tared)
    odd = _odd([numbers[one] for one in np.argsort(-away)], common)
    less, more, cop = list[int](), list[int](), dict[int, float]()
    for run, (force, *moment) in zip(numbers, shift - shift[at], strict=True):
        if abs(abs(force) - weight) < WHOLE * weight:
            (less if force > 0.0 else more).append(run)
        moved = float(np.hypot(*moment)) / weight
        # Under another weight it is a load, and no tare.
        if run in odd and moved > TILT_RAD * height and abs(force) < SAME * weight:
            cop[run] = moved
    if less or more:
        less = less or [run for run in numbers if run not in more]
        rest = tuple(run for run in numbers if run not in less)
        return MovedZeros(tuple(less), rest, cop)
    # A tare takes away the zeros, too: what it hides need not be the weight, nor a part of it.
    rest = tuple(run for run in numbers if run not in odd)
    if not cop and len(zeroed := _only(at_zero, odd, rest)):
        usual = np.median([shift[numbers.index(run)] for run in rest], axis=0)
        own = {run: shift[numbers.index(run)] - usual for run in odd}
        columns = {run: statics.parts[run].columns[zeroed] for run in odd}
        if all(_besides(own[run] / scale, columns[run] / scale) < BESIDES for run in odd):
            return MovedZeros(odd, rest, {}, channels=tuple(zeroed.tolist()))
    if apart := _apart(numbers, shift[:, 0], weight):
        return apart
    return MovedZeros((), (numbers[at],), cop) if cop else None


def _odd(order: Sequence[int], runs: Statics) -> tuple[int, ...]:
    """The fewest runs, of an order, whose own zeros alone explain what the runs contradict."""
    none = before = max(solve(runs.rows, runs.information).cost, LEAST_COST)
    for count in range(1, len(order)):
        left = solve(*with_own(runs, order[:count])).cost
        if before <= LEFT * none and left > NO_BETTER * before:
            return tuple(sorted(order[: count - 1]))
        before = left
    return tuple(sorted(order[:-1]))


def starts_at_zero(shoe: Shoe, at_zero: Mapping[int, FloatArray]) -> dict[int, tuple[int, ...]]:
    """By foot, the runs that start with all of its readings at zero.

    Runs that start so with both feet are left out.

    Args:
        shoe: with its channels.
        at_zero: (n,) by run in double support; see `starts`.
    """
    found: dict[int, list[int]] = {}
    for run, off in at_zero.items():
        most = np.array([off[shoe.of_foot(foot)].max() for foot in range(len(FEET))])
        if most.min() <= AT_ZERO and most.max() > BOTH_AT_ZERO:
            found.setdefault(int(np.argmin(most)), []).append(run)
    return {foot: tuple(numbers) for foot, numbers in sorted(found.items())}


def starts(runs: Mapping[int, Blocks]) -> dict[int, FloatArray]:
    """(n,) by run, how far each channel starts off zero, over its range in the run."""
    return {
        run: np.abs(one.readings[0]) / np.maximum(np.ptp(one.readings, axis=0), 1e-30)
        for run, one in runs.items()
    }


def _only(off: Mapping[int, FloatArray], runs: Sequence[int], rest: Sequence[int]) -> IntArray:
    """Channels that start at zero in all of some runs, and in none of the rest."""
    there = np.all([off[run] <= CHANNEL_AT_ZERO for run in runs], axis=0)
    return np.flatnonzero(there & np.all([off[run] > AT_ZERO for run in rest], axis=0))


def _besides(wrench: FloatArray, columns: FloatArray) -> float:
    """Share of a wrench (3,) that no zeros of k channels, whose columns are (k, 3), make up."""
    size, *_ = np.linalg.lstsq(columns.T, wrench, rcond=None)
    left = float(np.linalg.norm(wrench - size @ columns))
    return left / max(float(np.linalg.norm(wrench)), 1e-30)


def _apart(runs: Sequence[int], force: FloatArray, weight: float) -> MovedZeros | None:
    """Two groups of runs that differ by one part of the weight: some cells were zeroed.

    A single run that differs is left to `weights`: it may as well carry something.

    Args:
        force: (R,) that the runs read less than others [N].
    """
    order = np.argsort(force)
    at = int(np.argmax(np.diff(force[order]))) + 1
    more, less = order[:at], order[at:]
    within = max(float(np.ptp(force[group])) for group in (more, less))
    if min(len(more), len(less)) < LEAST_RUNS or within > WHOLE * weight:
        return None
    apart = float(np.median(force[less]) - np.median(force[more]))
    if apart < PART * weight:
        return None
    first, second = (tuple(sorted(runs[one] for one in group)) for group in (less, more))
    return MovedZeros(first, second, {}, apart)


def _shifts(runs: Statics) -> tuple[FloatArray, float, Statics]:
    """(R, 3) the runs' own wrenches [N, N m], the share of the misfit that they leave, and the
    runs with the weights that their blocks have then.
    """
    own, whole = with_own(runs, tuple(runs.parts))
    own = reweighed(own, whole)
    fit = solve(own, whole)
    rows = {run: replace(one, weight=own[run].weight) for run, one in runs.rows.items()}
    left = fit.cost / max(solve(rows, runs.information).cost, LEAST_COST)
    shift = fit.vector[len(runs.information) :].reshape(len(rows), 3)
    return shift, left, replace(runs, rows=rows)


def with_own(runs: Statics, free: Sequence[int]) -> tuple[dict[int, Equations], FloatArray]:
    """Equations in which the runs in `free` have wrenches of their own, and the prior information.

    The information (2n + 3r,) is that of gains and offsets (2n,) and of the wrenches of r runs.
    """
    count, own = len(free), {}
    scale = 1.0 / deviations(runs.weight, runs.settings)
    for run, one in runs.rows.items():
        columns = np.zeros((3, one.matrix.shape[1], count, 3))
        if run in free:
            columns[np.arange(3), :, free.index(run), np.arange(3)] = scale[:, None]
        own[run] = one.with_columns(columns.reshape(3, -1, 3 * count))
    # A tare takes away what stood on the channels: no more than the weight.
    usual = runs.weight * np.array([1.0, TORQUE_LEVER_M, TORQUE_LEVER_M])
    return own, np.concatenate((runs.information, np.tile(usual**-2.0, count)))


def all_start_at_zero(runs: Mapping[int, Blocks]) -> bool:
    """Whether runs in double support start with all readings at zero, each in another posture.

    In one and the same, zeros are those of a tare once before all runs, which does no harm.
    """
    begun = np.array([one.cop[0] for one in runs.values()])
    apart = float(np.linalg.norm(np.ptp(begun, axis=0))) > BEGIN_APART_M
    return apart and all(bool((off <= AT_ZERO).all()) for off in starts(runs).values())


def describe_starts(shoe: Shoe) -> list[Finding]:
    """Channels that were zeroed before each run, all of them alike, while the robot stood.

    Motion shows the zeros of single cells. Those of six-axis sensors count as known to what their
    data sheets say, and what each foot carried would be taken for the other one's.
    """
    before = (
        "all readings of both feet start at zero in each run, though the robot stands on them: "
    )
    if shoe.torque.any():
        text = (
            f"{before}the sensors were zeroed (bias) under load, which hides what each foot "
            "carried; set no bias while the robot stands, and record again"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    text = (
        f"{before}the cells were zeroed (tare) under load; what is calibrated holds for these "
        "zeros alone: zero them with both feet in the air, once, and record again"
    )
    return [Finding("WARN", text, Fault.MOVED_ZEROS)]


def describe_zeros(shoe: Shoe, found: MovedZeros, weight: float) -> list[Finding]:
    """Channels that were zeroed between the runs."""
    cure = (
        "set no bias while the robot stands"
        if shoe.torque.any()
        else "take the tare out of the firmware (HX711 libraries do it in setup())"
    )
    tare = (
        f"the cells were zeroed (tare) under load between the runs; {cure}, or keep the boards "
        "powered from the first run to the last, and record again"
    )
    if found.tared:
        before = " and ".join(
            f"the {FEET[foot]} foot before {name_runs(runs)}" for foot, runs in found.tared.items()
        )
        text = (
            f"all readings of a loaded foot start at zero ({before}), which hides what it carried: "
            f"{tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    than = name_runs(found.reference)
    if found.channels:
        names = [shoe.names[one] for one in found.channels]
        text = (
            f"the zeros of {name_runs(found.less)} are not those of {than}: {', '.join(names)} "
            f"{'start' if names[1:] else 'starts'} at zero there, which hides what the foot "
            f"carried: {tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    if found.less:
        less = (
            f"{name_runs(found.less)} {'read' if found.less[1:] else 'reads'} "
            f"{found.part or weight:.1f} N less than {than}, "
        )
        text = (
            f"{less}each by as much: if the robot carried nothing and was not held, some of {tare}"
            if found.part
            else f"{less}all of the robot's weight: {tare}"
        )
        return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
    moved = " and ".join(f"{1e3 * one:.0f}" for one in found.cop.values())
    text = (
        f"the zeros of {name_runs(tuple(found.cop))} are not those of {than}: the CoP "
        f"moves by {moved} mm with them, at the same weight; {tare}"
    )
    return [Finding("FAIL", text, Fault.MOVED_ZEROS)]
