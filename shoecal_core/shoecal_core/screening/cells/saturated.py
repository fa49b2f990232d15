"""Cells with flat tops or bottoms, be it within their converter's range.

A cell that stays at its own extreme while force is missing there, in the direction in which it
would have gone on, has reached an end. The end on the side of little load is that of a cell that
its screw preloads, or of an amplifier whose zero is too low.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording.run import Readings
from shoecal_core.recording.schemas import SATURATED
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import Blocks, ReadingBlocks
from shoecal_core.screening.cells.following import StuckBlocks, neighbours
from shoecal_core.screening.cells.unresponsive import joined
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.noise import spread
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

BEYOND_REACH = 10.0
"""Times the largest value of a converter that readings of all channels usually have, from which
they are none of it in that unit."""
USELESS_SHARE, USELESS_END_SHARE = 0.01, 0.2
"""A channel that is saturated for more of the time is no use: unknown to its device, and known."""
BEYOND_SHARE = 0.2
"""A channel at its end goes no further than this share of what it should, be the end a soft one."""
END_SHARE = 1e-6
"""Readings this near to an end of the range, as a share of it, are at the end."""
CEILINGS = tuple(2.0**bits - 1.0 for bits in (*range(10, 25), 31, 32))
"""Readings of converters at their upper end, in counts: 10 to 24 bits, with a sign or without."""
AT_END_STDS = 4.0
"""A reading is at its extreme when it is within this many standard deviations of it."""
MISSING_STDS, TREMBLING_STDS = 0.5, 3.0
"""Less missing force does not count, in the settings' standard deviations of the force, and in
those of the force's noise."""
SCATTER_STDS = 2.5
"""Nor does force that may be missing by chance: in standard deviations of the force's error while
the cell is away from its extreme, for one visit there; of several visits the mean counts."""
LEAST_S = 0.6
"""Time at the extreme from which missing force counts [s]."""
AROUND, COMES_SHARE = 5, 0.5
"""Blocks before and after a visit to an extreme, and what part of the missing force is to come with
the visit and go with it: a gain that drifts lets as much be missing on both sides."""
NEIGHBOURS_SHARE = 0.5
"""Of its range, that a neighbour goes through while a cell at its end stays there: preloaded ones
came to 0.98 and more. While a sound cell turns round, or its foot hangs, it is 0.02."""


@dataclass(frozen=True)
class Saturated:
    """A channel that has an end.

    Attributes:
        channel: index.
        level: the end, as it reads.
        side: 1.0 where it is the largest of its readings, -1.0 where it is the least.
        missing: force that is missing there at times [N].
        share: of all blocks.
        force: what the end reads, roughly; NaN where that is not known [N].
    """

    channel: int
    level: float
    side: float
    missing: float
    share: float
    force: float = float("nan")


def at_ends(shoe: Shoe, values: FloatArray) -> BoolArray:
    """(T, n) readings (T, n) at an end of their converter's range, or at another's ceiling."""
    low, high = (
        np.array([getattr(c, end) for c in shoe.channels]) for end in ("lowest", "highest")
    )
    slack = END_SHARE * (high - low)
    ends: BoolArray = (values <= low + slack) | (values >= high - slack) | _at_ceiling(values)
    return ends


def _at_ceiling(values: FloatArray) -> BoolArray:
    """(T, n) readings (T, n) that are a converter's ceiling, by counts alone.

    A channel that passes such a count reads others near it, too.
    """
    counts = np.where(np.isfinite(values), values, -np.inf)
    there: BoolArray = np.isin(counts, CEILINGS) & (counts == counts.max(axis=0, initial=-np.inf))
    for channel in np.flatnonzero(there.any(axis=0)):
        mine = there[:, channel]
        rest = values[~mine & np.isfinite(values[:, channel]), channel]
        if len(rest) and values[mine, channel][0] - rest.max() <= np.ptp(rest):
            there[:, channel] = False
    return there


def at_ends_or_marked(shoe: Shoe, readings: Readings) -> BoolArray:
    """(T, n) the same, and readings that the device marks as saturated."""
    ends: BoolArray = at_ends(shoe, readings.value) | (readings.status == SATURATED)
    return ends


def within_range(shoe: Shoe, aligned: Aligned) -> Aligned:
    """A run without samples at a converter's end, which look like a force from outside."""
    ends: BoolArray = np.any(at_ends(shoe, aligned.readings), axis=1)
    # A run that is there for most of the time is left out later, and named.
    return aligned.part(np.logical_not(ends)) if 2 * ends.sum() < len(ends) else aligned


def ended(runs: Mapping[int, ReadingBlocks], found: Sequence[StuckBlocks]) -> list[Saturated]:
    """Of channels that were stuck: those that should have gone beyond an end, and never do.

    One that is stuck there by chance goes beyond at other times, or should have come back.
    """
    readings = joined(runs)
    at_end = []
    for stuck in found:
        values = readings[:, stuck.channel]
        level = float(np.median(values[stuck.still]))
        expected = stuck.expected[stuck.still] - level
        side = float(np.sign(np.median(expected)))
        if np.max(side * (values - level)) < BEYOND_SHARE * np.max(side * expected):
            noise = max(float(blocks.noise[stuck.channel]) for blocks in runs.values())
            share = float(np.mean(np.abs(values - level) <= AT_END_STDS * noise))
            at_end.append(Saturated(stuck.channel, level, side, float("nan"), share))
    return at_end


def flat(shoe: Shoe, runs: Mapping[int, Blocks]) -> dict[int, BoolArray]:
    """(B,) by run, blocks in which a cell stays at its extreme while a neighbour goes on.

    They say nothing of the cell's gain; of one that is there for most of the time, they would.
    """
    readings = joined(runs)
    noise = np.max([blocks.noise for blocks in runs.values()], axis=0)
    everything = np.zeros(len(readings), dtype=bool)
    for channel in np.flatnonzero(shoe.vertical).tolist():
        near = readings[:, [k for k in neighbours(shoe, channel) if shoe.vertical[k]]]
        values = readings[:, channel]
        for level in (values.min(), values.max()):
            there = np.abs(values - level) <= AT_END_STDS * noise[channel]
            if np.any(np.ptp(near[there], axis=0) > NEIGHBOURS_SHARE * np.ptp(near, axis=0)):
                everything |= there
    ends = np.cumsum([len(blocks.time) for blocks in runs.values()])[:-1]
    return dict(zip(runs, np.split(everything, ends), strict=True))


def saturated(
    runs: Mapping[int, Blocks],
    force_error: Mapping[int, FloatArray],
    parameters: ChannelParameters,
    settings: CalibrationSettings,
) -> list[Saturated]:
    """Every channel with a flat top or bottom.

    Args:
        force_error: (B,) measured less expected force of each run's blocks [N].
        parameters: gains and offsets of the n channels, roughly.
    """
    gain = parameters.gain
    readings = np.concatenate([blocks.readings for blocks in runs.values()])
    noise = np.max([blocks.noise for blocks in runs.values()], axis=0)
    # A run under another weight is off all the time.
    errors = [force_error[run] - np.median(force_error[run]) for run in runs]
    error = np.concatenate(errors)
    ends = np.cumsum([len(one) for one in errors])
    period = float(np.median([blocks.period for blocks in runs.values()]))
    trembling = float(np.linalg.norm(gain * noise))
    least = max(MISSING_STDS * settings.force_std_n, TREMBLING_STDS * trembling)
    found = []
    for channel, values in enumerate(readings.T):
        for side in (1.0, -1.0):
            level = side * float(np.max(side * values))
            there = np.abs(values - level) <= AT_END_STDS * noise[channel]
            if there.sum() * period < LEAST_S:
                continue
            lacking = -float(np.sign(gain[channel])) * side * error
            missing = float(np.median(lacking[there]))
            scatter = 0.0 if there.all() else float(spread(error[~there]))
            visits = 1 + int(np.count_nonzero(np.diff(np.flatnonzero(there)) > 1))
            if missing > max(least, SCATTER_STDS * scatter / np.sqrt(visits)) and _comes(
                lacking, there, ends
            ):
                force = float(gain[channel] * level + parameters.offset[channel])
                share = float(there.mean())
                found.append(Saturated(channel, level, side, missing, share, force))
    return found


def _comes(lacking: FloatArray, there: BoolArray, ends: IntArray) -> bool:
    """Whether most of the missing force comes and goes with the visits to an extreme.

    Args:
        lacking: (B,) force that is missing [N].
        there: (B,) at the extreme.
        ends: of each run, one behind its last block.
    """
    rises, sizes = list[float](), list[float]()
    for first, last in _visits(there, ends):
        start, end = (int(ends[ends <= first].max(initial=0)), int(ends[ends > first].min()))
        sides = (lacking[max(start, first - AROUND) : first], lacking[last : last + AROUND])
        sides = (sides[0], sides[1][: end - last])
        visit = lacking[first:last][there[first:last]]
        around = [float(np.median(side)) for side in sides if len(side)]
        rises.append(float(np.median(visit)) - max(around, default=0.0))
        sizes.append(float(np.median(visit)))
    return float(np.median(rises)) > COMES_SHARE * float(np.median(sizes))


def _visits(there: BoolArray, ends: IntArray) -> list[tuple[int, int]]:
    """First block and one behind the last of each visit; short leaves are part of one."""
    at = np.flatnonzero(there)
    run = np.searchsorted(ends, at, side="right")
    parted = np.flatnonzero((np.diff(at) > AROUND) | (np.diff(run) > 0)) + 1
    return [(int(one[0]), int(one[-1]) + 1) for one in np.split(at, parted)]


def describe_saturated(shoe: Shoe, found: Sequence[Saturated]) -> list[Finding]:
    """Channels that reached an end."""
    return [
        Finding(
            "FAIL" if one.share > USELESS_SHARE else "WARN",
            f"{shoe.names[one.channel]} {_end(shoe, one)}",
            Fault.SATURATED,
        )
        for one in found
    ]


def _end(shoe: Shoe, one: Saturated) -> str:
    level = f"{one.level:.6g} {shoe.unit}"
    if shoe.vertical[one.channel] and one.side * shoe.polarity[one.channel] < 0.0:
        force = "" if np.isnan(one.force) else f" (about {one.force:.1f} N)"
        return (
            f"does not answer to low load: it stays at {level}{force} for {one.share:.1%} of the "
            "time: it is preloaded, by its screw or the shoe, or its amplifier ends there; loosen "
            "its screw, or move its amplifier's zero, then record again"
        )
    missing = "" if np.isnan(one.missing) else f", with {one.missing:.1f} N missing"
    return (
        f"is saturated: it goes no further than {level}, where it is for {one.share:.1%} of the "
        f"time{missing}: lower its amplification"
    )


def describe_ends(shoe: Shoe, ends: BoolArray, readings: FloatArray) -> list[Finding]:
    """Channels at the end of their converter's range: every such reading counts, in use too.

    Args:
        ends: (T, n) which of the readings (T, n) are at an end.
    """
    share = ends.mean(axis=0)
    useless = share > USELESS_END_SHARE
    reach = np.array([max(abs(one.lowest), abs(one.highest)) for one in shoe.channels])
    usual = np.nanmedian(np.abs(readings), axis=0)
    if useless.all() and (usual > BEYOND_REACH * reach).all():
        return [
            Finding(
                "FAIL",
                f"readings of about {np.median(usual):.3g} lie far beyond the {reach.max():g} "
                f"{shoe.unit} that the converter gives: are they counts, or in another unit? Give "
                "'scale' in the mapping of the import, or 'unit' and 'converter' of the readings "
                "in the shoe file",
                Fault.UNIT,
            )
        ]
    findings = []
    for verdict, channels in (("FAIL", useless), ("WARN", (share > 0.0) & ~useless)):
        if not channels.any():
            continue
        names = [shoe.names[channel] for channel in np.flatnonzero(channels)]
        there = ends & channels
        count = int(there.any(axis=1).sum())
        levels = np.unique(readings[there & np.isfinite(readings)])
        level = f", at {levels[0]:.10g} {shoe.unit}" if len(levels) == 1 else ""
        one = len(names) == 1
        findings.append(
            Finding(
                verdict,
                f"{', '.join(names)} {'is' if one else 'are'} at the end of "
                f"{'its' if one else 'their'} range in {count / len(ends):.1%} of the samples "
                f"({count} of {len(ends)} messages{level}), where the converter goes no further: "
                f"lower {'its' if one else 'their'} amplification or check "
                f"{'its' if one else 'their'} wiring",
                Fault.SATURATED,
            )
        )
    return findings
