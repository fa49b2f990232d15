"""A run in short blocks: medians that single bad samples do not move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.level import standing_samples
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import typical_period
from shoecal_core.screening.noise import noise, resolution
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import columns_in_left, combined, weight_below

BLOCK_S = 0.2
"""A slow robot hardly moves in so short a time."""


@dataclass(frozen=True)
class ReadingBlocks:
    """B blocks of one run's readings.

    Attributes:
        time: (B,) of their middles, since the run's start [s].
        readings: (B, n) medians.
        noise: (n,) standard deviation of a block's reading.
    """

    time: FloatArray
    readings: FloatArray
    noise: FloatArray

    @property
    def period(self) -> float:
        """Time from one block to the next [s]."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else BLOCK_S


@dataclass(frozen=True)
class Blocks(ReadingBlocks):
    """The same of a run in double support; vectors are in the left sole's frame.

    Attributes:
        cop: (B, 2) modelled CoP, means [m].
        columns: (n, 3) what one unit of each output adds to the total wrench.
        base: (3,) wrench of the parts below the channels.
    """

    cop: FloatArray
    columns: FloatArray
    base: FloatArray


def reading_blocks(time: FloatArray, readings: FloatArray) -> ReadingBlocks:
    """Blocks of readings (T, n) at times (T,) since the run's start [s]."""
    size = block_size(time)
    # The median of a sample is less sharp than its mean.
    sharper = np.sqrt(np.pi / 2.0 / size) if size > 2 else 1.0 / np.sqrt(size)
    return ReadingBlocks(
        time=in_blocks(time, size).mean(axis=1),
        readings=np.median(in_blocks(readings, size), axis=1),
        # A median of a converter's steps is one of them again.
        noise=np.maximum(noise(readings) * sharper, resolution(readings) / np.sqrt(12.0)),
    )


def blocks(aligned: Aligned, shoe: Shoe) -> Blocks:
    """Blocks of a run whose feet stand where the joint angles say while both stand."""
    support = aligned.states.part(standing_samples(aligned.states)).support()
    shown = reading_blocks(aligned.time, aligned.readings)
    return Blocks(
        time=shown.time,
        readings=shown.readings,
        noise=shown.noise,
        cop=in_blocks(aligned.states.cop[:, 0], block_size(aligned.time)).mean(axis=1),
        columns=columns_in_left(shoe, support),
        base=combined(weight_below(shoe), support),
    )


def one_after_another(starts: Sequence[float], lengths: Sequence[float]) -> list[float]:
    """Starts of runs that follow each other [s]: none begins before the last one ended.

    Runs without the time of day all begin at zero.
    """
    found, end = list[float](), -np.inf
    for start, length in zip(starts, lengths, strict=True):
        found.append(float(max(start, end)))
        end = found[-1] + length
    return found


def block_size(time: FloatArray) -> int:
    """Number of samples a block, for samples at times (T,) [s]."""
    return max(1, round(BLOCK_S / typical_period(time)))


def in_blocks(values: FloatArray, size: int) -> FloatArray:
    """(B, size, ...) of samples (T, ...); the rest at the end is left out."""
    count = len(values) // size
    return values[: count * size].reshape(count, size, *values.shape[1:])
