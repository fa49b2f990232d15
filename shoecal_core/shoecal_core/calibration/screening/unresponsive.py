"""Cells that do not answer: dead all the time, or stuck for some of it while others move.

A channel is held against the others of its foot and kind. What it moves by beyond its noise is
compared, in windows so long that no living channel stays flat while its neighbours move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from shoecal_core.calibration.screening.blocks import Blocks
from shoecal_core.calibration.screening.stretches import stretches
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

DEAD_SHARE = 0.02
"""A channel that moves by less than this share of the others' range is dead."""
WINDOW_S = 8.0
STUCK_SHARE = 0.01
"""A channel is stuck while it moves by less than this share of what the others do, each measured
by its own range. Near its turning point a living one, under a large robot that takes its time, came
down to 0.018."""
MOVING_SHARE = 0.08
"""The others move when they go through this share of their range."""
LEAST_RANGE = 0.2
"""A living channel's range is at least this share of the others'."""
NOISE_RANGE = 3.0
"""Part of a range that may be noise, in standard deviations of a block."""


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


def dead(shoe: Shoe, runs: Mapping[int, Blocks]) -> list[int]:
    """Channels that no run moves, though it moves the others; or that never change at all."""
    moved = _ranges(runs)
    constant = np.ptp(np.concatenate([one.readings for one in runs.values()]), axis=0) == 0.0
    still = []
    for channel in range(len(moved)):
        usual = float(np.max(moved[neighbours(shoe, channel)], initial=0.0))
        if constant[channel] or moved[channel] < DEAD_SHARE * usual:
            still.append(channel)
    return still


def stuck(shoe: Shoe, runs: Mapping[int, Blocks], alive: Sequence[int]) -> list[Stuck]:
    """Every stretch in which a living channel stays where it is while its neighbours move.

    The moments of a six-axis sensor are left alone: a CoP that moves along one axis of the sole
    keeps the moment of the other for as long as it does.
    """
    whole = _ranges(runs)
    found = []
    for run, blocks in runs.items():
        size = round(WINDOW_S / blocks.period)
        if len(blocks.time) < size:
            continue
        windows = sliding_window_view(blocks.readings, size, axis=0)
        moved = np.maximum(np.ptp(windows, axis=-1) - NOISE_RANGE * blocks.noise, 0.0)
        for channel in alive:
            others = [one for one in neighbours(shoe, channel) if one in alive]
            if shoe.torque[channel] or not others:
                continue
            # A channel that was stuck for long has had no chance to show its range.
            own = max(whole[channel], LEAST_RANGE * float(np.median(whole[others])))
            share = np.median(moved[:, others] / whole[others], axis=1)
            flat = (share > MOVING_SHARE) & (moved[:, channel] / own < STUCK_SHARE * share)
            found += _stretches(run, channel, blocks, flat, size)
    return found


def neighbours(shoe: Shoe, channel: int) -> IntArray:
    """Channels of the same foot and kind."""
    same = (shoe.foot == shoe.foot[channel]) & (shoe.torque == shoe.torque[channel])
    same[channel] = False
    return np.flatnonzero(same)


def _stretches(run: int, channel: int, blocks: Blocks, flat: BoolArray, size: int) -> list[Stuck]:
    """Flat windows put together; each is named by its first block."""
    still = np.zeros(len(blocks.time), dtype=bool)
    for start in np.flatnonzero(flat):
        still[start : start + size] = True
    return [
        Stuck(
            run,
            channel,
            start,
            end,
            float(
                np.median(blocks.readings[(blocks.time >= start) & (blocks.time <= end), channel])
            ),
        )
        for start, end in stretches(still, blocks.time)
    ]


def _ranges(runs: Mapping[int, Blocks]) -> FloatArray:
    """(n,) how far each channel moves in the whole session, beyond its noise."""
    readings = np.concatenate([blocks.readings for blocks in runs.values()])
    noise = np.max([blocks.noise for blocks in runs.values()], axis=0)
    low, high = np.percentile(readings, [1.0, 99.0], axis=0)
    moved: FloatArray = np.maximum(high - low - NOISE_RANGE * noise, 0.0)
    return moved
