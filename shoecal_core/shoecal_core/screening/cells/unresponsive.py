"""Cells that do not answer: dead all the time, or stuck for some of it while others move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.stretches import stretches
from shoecal_core.screening.blocks import ReadingBlocks
from shoecal_core.screening.cells.following import NOISE_RANGE, StuckBlocks, all_stuck, neighbours
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.vertical import polarity_known, vertical_forces

DEAD_SHARE = 0.02
"""A channel that moves by less than this share of the others' range is dead."""
USUAL_SHARE = 0.5
"""Of how far the other foot's load usually goes, it does at least while one foot is dead."""
LIVING = 0.05
"""Part of a session in which a dead channel may have lived: less is not enough to fit a law."""


@dataclass(frozen=True)
class Stuck:
    """A channel that did not follow for some time.

    Attributes:
        run: number of the run.
        channel: index.
        start, end: since the run's start [s].
        level: where it stood, as it reads.
    """

    run: int
    channel: int
    start: float
    end: float
    level: float


def dead(shoe: Shoe, runs: Mapping[int, ReadingBlocks]) -> list[int]:
    """Channels that hardly any time moves, though it moves the others; or that never change."""
    moved = _ranges(runs)
    constant = np.ptp(joined(runs), axis=0) == 0.0
    return [
        channel
        for channel in range(len(moved))
        if constant[channel] or moved[channel] < _least(shoe, moved, channel)
    ]


def dead_feet(shoe: Shoe, runs: Mapping[int, ReadingBlocks]) -> dict[int, int]:
    """The foot (index) of which no channel moves in a run where the other one's load does, by run.

    The load of the other one, since a foot may also hang: then that stays the weight. Nothing where
    the polarity of vertical channels is not known, or with one run.
    """
    if len(runs) < 2 or not polarity_known(shoe):
        return {}
    ranges = {run: _ranges({run: blocks}) for run, blocks in runs.items()}
    loads = {
        run: np.ptp(vertical_forces(shoe, blocks.readings)[0], axis=0)
        for run, blocks in runs.items()
    }
    found = {}
    for run, moved in ranges.items():
        others = [number for number in ranges if number != run]
        usual = np.median([ranges[number] for number in others], axis=0)
        load = loads[run] > USUAL_SHARE * np.median([loads[number] for number in others], axis=0)
        for foot in (0, 1):
            own = (usual > 0.0) & (shoe.foot == foot)
            if own.any() and np.all(moved[own] < DEAD_SHARE * usual[own]) and load[1 - foot]:
                found[run] = foot
    return found


def away(shoe: Shoe, runs: Mapping[int, ReadingBlocks], channel: int) -> BoolArray:
    """(B,) blocks in which a dead channel is not where it mostly is."""
    values = joined(runs)[:, channel]
    least = _least(shoe, _ranges(runs), channel) + NOISE_RANGE * _noise(runs)[channel]
    left: BoolArray = np.abs(values - np.median(values)) > least
    return left


def stuck_channels(
    shoe: Shoe, runs: Mapping[int, ReadingBlocks], silent: Sequence[int]
) -> list[StuckBlocks]:
    """Channels that were stuck for some time, the clearest first.

    Args:
        runs: in the order in which they were recorded.
        silent: dead channels.
    """
    alive = [channel for channel in range(len(shoe.names)) if channel not in silent]
    return all_stuck(shoe, joined(runs), _noise(runs), alive)


def stuck(runs: Mapping[int, ReadingBlocks], found: Sequence[StuckBlocks]) -> list[Stuck]:
    """Every stretch of each run in which one of these channels was stuck."""
    ends = np.cumsum([len(blocks.time) for blocks in runs.values()])[:-1]
    return [
        Stuck(run, one.channel, start, end, _level(blocks, one.channel, start, end))
        for one in found
        for (run, blocks), still in zip(runs.items(), np.split(one.still, ends), strict=True)
        for start, end in stretches(still, blocks.time)
    ]


def joined(runs: Mapping[int, ReadingBlocks]) -> FloatArray:
    """(B, n) raw readings of the blocks of all runs, one after the other."""
    return np.concatenate([blocks.readings for blocks in runs.values()])


def _level(blocks: ReadingBlocks, channel: int, start: float, end: float) -> float:
    part = (blocks.time >= start) & (blocks.time <= end)
    return float(np.median(blocks.readings[part, channel]))


def _ranges(runs: Mapping[int, ReadingBlocks]) -> FloatArray:
    """(n,) how far each channel moves in most of the session, beyond its noise; 0 if hardly.

    About where it stands in each run: a dead one may wander as its electronics warm up.
    """
    moves = [blocks.readings - np.median(blocks.readings, axis=0) for blocks in runs.values()]
    low, high = np.quantile(np.concatenate(moves), [LIVING, 1.0 - LIVING], axis=0)
    trembling = NOISE_RANGE * _noise(runs)
    moved: FloatArray = np.where(high - low > 2.0 * trembling, high - low - trembling, 0.0)
    return moved


def _least(shoe: Shoe, moved: FloatArray, channel: int) -> float:
    """How far a living channel moves, by its neighbours."""
    return DEAD_SHARE * float(np.max(moved[neighbours(shoe, channel)], initial=0.0))


def _noise(runs: Mapping[int, ReadingBlocks]) -> FloatArray:
    """(n,) the largest of any run."""
    noise: FloatArray = np.max([blocks.noise for blocks in runs.values()], axis=0)
    return noise


def describe_dead(shoe: Shoe, channels: Sequence[int]) -> list[Finding]:
    """Channels that never answer."""
    return [
        Finding(
            "FAIL",
            f"{shoe.names[channel]} does not answer to load: check its cable, then record again",
            Fault.DEAD,
        )
        for channel in channels
    ]


def describe_dead_feet(feet: Mapping[int, int]) -> list[Finding]:
    """Feet of which nothing answers in single runs."""
    findings = []
    for foot, name in enumerate(FEET):
        runs = sorted(run for run, one in feet.items() if one == foot)
        if runs:
            text = (
                f"nothing of the {name} foot answers in {name_runs(runs)}, though it does in others"
                ": check its plug and its driver, then record again, or leave these runs out"
            )
            findings.append(Finding("FAIL", text, Fault.DEAD))
    return findings


def describe_stuck(shoe: Shoe, found: Sequence[Stuck]) -> list[Finding]:
    """Channels that stopped answering, each with all its stretches."""
    findings = []
    for channel in sorted({one.channel for one in found}):
        own = [one for one in found if one.channel == channel]
        places = ", ".join(f"run {one.run} from {one.start:.0f} to {one.end:.0f} s" for one in own)
        findings.append(
            Finding(
                "FAIL",
                f"{shoe.names[channel]} is stuck at {own[0].level:.4g} {shoe.unit} while its "
                f"neighbours move ({places}): check its cable, then record again, or leave these "
                "runs out",
                Fault.STUCK,
            )
        )
    return findings
