"""Readings that lack codes of their converter, and drivers that hold a value until it has changed.

A bit that never changes leaves gaps: codes that are never read, though the readings go from one
side to the other again and again. A driver that sends on change only repeats a value, then steps
by more than its dead band, though the values that it sends lie much closer together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.noise import noise
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

_BEFORE, _AFTER = slice(None, -1), slice(1, None)
LEAST_GAP, USUAL = 8.0, 0.9
"""A gap is wider than so many steps from one reading to the next (a tenth is larger), and standard
deviations of the noise: a sound channel that crosses it leaves some readings within."""
EDGE, TIGHT = 0.1, 1.0 / 3.0
"""Of the gap's width, within which readings before and after a step over it lie at both edges, and
of the steps, for which that is so at least: half of them where a bit is missing. A spike, a jolt or
a foot that is put down begins and ends anywhere: one in a hundred."""
CROSSINGS = 5
"""Such steps, at least."""
SIDE_SHARE = 0.01
"""Of the readings, that lie on each side of the gap at least."""
HELD_SHARE = 0.5
"""Of the readings, that repeat the one before in a driver that holds them; of a driver without a
dead band 0.01, of one that repeats slow readings nine of ten, but its steps are of any size."""
EVEN, SMALLEST = 0.5, 0.01
"""Smallest steps (a hundredth is smaller) over their median: 0.92 and more with a
dead band, 0.01 to 0.07 of sound recordings, simulated and real."""
FINER = 4.0
"""Smallest steps over the median distance between different values: 13 and more with a dead band;
of a coarse converter 1, since its step is both."""
LEAST_VALUES = 20
"""Different values of a channel from which their distance is known."""
LEAST_CODES = 5
"""Different values on either side of a gap: a sensor that answers from a threshold on, as force
sensing resistors do, has one below it."""
NOTABLE_BAND, LARGEST_BAND = 0.01, 0.05
"""Dead bands over a channel's range: less than the first is not reported, from the second on the
recording is refused. A held value is off by up to the band, evenly: by 0.6 of it (RMS), so
that a foot's CoP is off by about as large a part of the sole's half length as the band is of the
cells' range: 0.5 mm of a NAO's with the first, 2.5 mm with the second, as much as `cop_std_m`."""


@dataclass(frozen=True)
class MissingCodes:
    """Readings that a channel never gives.

    Attributes:
        channel: index.
        low, high: readings at the gap's edges.
        crossings: steps from one edge to the other.
    """

    channel: int
    low: float
    high: float
    crossings: int


@dataclass(frozen=True)
class DeadBand:
    """A channel that is held until it has changed by so much.

    Attributes:
        channel: index.
        band: least change, in its unit.
        share: of the channel's range.
        held: share of the readings that repeat the one before.
    """

    channel: int
    band: float
    share: float
    held: float


def missing_codes(runs: Mapping[int, Run]) -> list[MissingCodes]:
    """Channels with gaps in their codes; of each the one that is crossed most.

    A foot that is put down lets all its channels jump at once, a converter lets its own alone.
    """
    values = [run.readings.value for run in runs.values()]
    steps = np.concatenate([np.abs(np.diff(one, axis=0)) for one in values])
    known = np.isfinite(steps)
    usual = np.array(
        [np.quantile(own[there], USUAL) if there.any() else np.inf
         for own, there in zip(steps.T, known.T, strict=True)]
    )  # fmt: skip
    jumps = steps > LEAST_GAP * usual
    found = []
    for channel in range(steps.shape[1]):
        alone = known[:, channel] & ~np.delete(jumps, channel, axis=1).any(axis=1)
        parts = [one[:, channel] for one in values]
        gaps = [MissingCodes(channel, *gap) for gap in _gaps(parts, alone, float(usual[channel]))]
        if gaps:
            found.append(max(gaps, key=lambda one: one.crossings))
    return found


def _gaps(
    parts: Sequence[FloatArray], alone: BoolArray, usual: float
) -> list[tuple[float, float, int]]:
    """Edges of gaps in a channel's values, each run's (T,), and steps from edge to edge.

    Args:
        alone: (S,) of all runs' steps, at which no other channel jumps.
        usual: size of a step.
    """
    values = np.sort(np.concatenate([one[np.isfinite(one)] for one in parts]))
    side = round(SIDE_SHARE * len(values))
    inner = values[side : len(values) - side]
    if len(inner) < LEAST_VALUES:
        return []
    before, after = (np.concatenate([one[part] for one in parts]) for part in (_BEFORE, _AFTER))
    before, after = before[alone], after[alone]
    width = LEAST_GAP * max(usual, *(float(noise(one[:, None])[0]) for one in parts))
    least, most = np.minimum(before, after), np.maximum(before, after)
    found = []
    for at in np.flatnonzero(np.diff(inner) > width):
        low, high = float(inner[at]), float(inner[at + 1])
        if min(len(np.unique(inner[: at + 1])), len(np.unique(inner[at + 1 :]))) < LEAST_CODES:
            continue
        across = (least <= low) & (most >= high)
        slack = EDGE * (high - low)
        tight = int((across & (least >= low - slack) & (most <= high + slack)).sum())
        if tight >= CROSSINGS and tight >= TIGHT * across.sum():
            found.append((low, high, tight))
    return found


def dead_bands(runs: Mapping[int, Run]) -> list[DeadBand]:
    """Channels that are held until they have changed by a notable part of their range."""
    found = []
    for channel, parts in enumerate(_by_channel(runs)):
        steps = np.concatenate([np.abs(np.diff(one)) for one in parts])
        moved = steps[steps > 0.0]
        values = np.unique(np.concatenate(parts))
        held = 1.0 - len(moved) / max(1, len(steps))
        if len(values) < LEAST_VALUES or held < HELD_SHARE:
            continue
        band = float(np.quantile(moved, SMALLEST))
        share = band / float(np.ptp(values))
        even = band > EVEN * float(np.median(moved))
        if even and band > FINER * float(np.median(np.diff(values))) and share > NOTABLE_BAND:
            found.append(DeadBand(channel, band, share, held))
    return found


def _by_channel(runs: Mapping[int, Run]) -> list[list[FloatArray]]:
    """Of each channel, the finite readings (T,) of each run."""
    values = [run.readings.value for run in runs.values()]
    count = values[0].shape[1]
    return [[one[np.isfinite(one[:, i]), i] for one in values] for i in range(count)]


def describe_missing_codes(shoe: Shoe, found: Sequence[MissingCodes]) -> list[Finding]:
    """Channels that lack codes."""
    findings = []
    for one in found:
        digits = max(0, 2 - int(np.floor(np.log10(one.high - one.low))))
        findings.append(
            Finding(
                "FAIL",
                f"{shoe.names[one.channel]} never reads between {one.low:.{digits}f} and "
                f"{one.high:.{digits}f} {shoe.unit}, though it steps from one to the other "
                f"{one.crossings} times: a bit of its converter does not change; check the "
                "converter and the lines and timing by which it is read (SPI), then record again",
                Fault.CODES,
            )
        )
    return findings


def describe_dead_bands(shoe: Shoe, found: Sequence[DeadBand]) -> list[Finding]:
    """Channels that are held by their driver."""
    if not found:
        return []
    worst = max(found, key=lambda one: one.share)
    names = ", ".join(shoe.names[one.channel] for one in found)
    many = "all channels" if len(found) == len(shoe.names) > 1 else names
    return [
        Finding(
            "FAIL" if worst.share > LARGEST_BAND else "WARN",
            f"{many} repeat {worst.held:.0%} of their readings and then step by "
            f"{worst.band:.3g} {shoe.unit} or more (up to {worst.share:.0%} of their range): the "
            "driver or the device sends changes only (dead band); turn that off, or set it to "
            "zero, then record again",
            Fault.CODES,
        )
    ]
