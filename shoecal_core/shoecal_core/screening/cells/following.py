"""Channels that stop following the others, be it for good, for a while, or again and again.

Weights and plates tie a shoe's channels to each other: each one follows from the others by a linear
law. The law is fitted to all blocks outside a stretch, for every stretch that a session has. Where
inside the stretch the channel stays while the law says that it moves, or shows only a small part of
that motion, it is stuck. A law that is not exact leaves a residual, and only motion that is much
larger than that residual counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.shoe.shoe import Shoe

FOLLOWS = 0.35
"""A channel that shows more of its expected motion follows the others, though with another gain."""
BROKEN = 0.05
"""Squares that a stuck reading leaves in a stretch, at most, over those that the law leaves."""
STILL_STDS = 3.0
"""A stuck reading leaves no more than this in a stretch, in the law's standard deviations."""
STILL_SHARE = 0.15
"""What it leaves, over the standard deviation of the expected motion, at most. A cell whose law is
broken by a hand or a rope goes on moving: under a hand, two cells came to 0.2 and 0.4."""
SUSPECT_STDS, SURE_STDS = 2.0, 6.0
"""Standard deviation of the expected motion in a stretch, in those of what the law leaves: from
the first the law is fitted without the stretch, from the second the channel is stuck. Cells that
follow came to 3.6, cells that were stuck to 23 and more."""
AWAY, CONSTANT = 2.0, 0.05
"""The same of the distance from the law at which an open input rests, over those of the motion that
is sure; and what it leaves of that motion, at most. A cell that is pressed goes on moving."""
LEAST_BLOCKS = 10
"""Shorter stretches are no evidence."""
COARSE, FINE = 60, 400
"""Stretches start and end at one of so many moments: while a law is fitted to each, and once one
law is known."""
ROUNDS, EXACT_ROUNDS = 3, 2
"""Times that the law is fitted again without the stretch, and with its ends to single blocks."""
MOST_STRETCHES = 10
"""That one channel may have."""
CORRELATED = 10
"""Blocks in which a law leaves about the same: no more than one of them counts for its error."""
LEAST_OUTSIDE = 0.05
"""Part of all blocks that a law is fitted to, at least."""
WINDOW, STIR_SHARE, FLAT_SHARE = 10, 0.02, 0.05
"""Blocks of a window. A channel is flat in it that moves by less than the last share of what its
neighbours do, each measured by its own range, where they go through the first share of it. That is
no evidence, since living channels turn, but laws are fitted to other blocks."""
STIRRED = 0.25
"""Part of a stretch for which a neighbour of a stuck channel is away from its median, at least."""
NOISE_RANGE = 3.0
"""Part of a range that may be noise, in standard deviations of a block."""
RIDGE = 1e-8
"""Added to the normal matrix of standardised readings: some directions never move."""


@dataclass(frozen=True)
class StuckBlocks:
    """A channel that was stuck.

    Attributes:
        channel: index.
        still: (T,) blocks in which it was.
        expected: (T,) what it should have shown by the law.
        share: of its signal that stayed behind, 1 where it did not move at all.
        law: (1 + n,) by which it follows all channels otherwise, a constant first.
        broken: squares that the stuck reading leaves, over those that the law leaves.
    """

    channel: int
    still: BoolArray
    expected: FloatArray
    share: float
    law: FloatArray
    broken: float


def all_stuck(
    shoe: Shoe, readings: FloatArray, noise: FloatArray, alive: Sequence[int]
) -> list[StuckBlocks]:
    """Every channel that was stuck, the clearest first.

    The law of a channel uses no other one that was stuck. The moments of a six-axis sensor are left
    alone: a CoP that moves along one axis of the sole keeps the moment of the other meanwhile.

    Args:
        readings: (T, n) blocks of all runs, one after the other.
        noise: (n,) standard deviation of a block.
        alive: channels that answer to load.
    """
    found: list[StuckBlocks] = []
    going = list(alive)
    while True:
        stuck = [
            one
            for channel in going
            if not shoe.torque[channel]
            and (one := _stuck_blocks(shoe, readings, noise, channel, going))
        ]
        if not stuck:
            return found
        clearest = min(stuck, key=lambda one: one.broken)
        found.append(clearest)
        going.remove(clearest.channel)


def neighbours(shoe: Shoe, channel: int) -> IntArray:
    """(k,) indices of the other channels of the same foot and kind."""
    same = (shoe.foot == shoe.foot[channel]) & (shoe.torque == shoe.torque[channel])
    same[channel] = False
    return np.flatnonzero(same)


def _stuck_blocks(
    shoe: Shoe, readings: FloatArray, noise: FloatArray, channel: int, going: Sequence[int]
) -> StuckBlocks | None:
    others = [one for one in going if one != channel]
    near = [one for one in neighbours(shoe, channel).tolist() if one in others]
    if not near or len(readings) < LEAST_BLOCKS + 2 * len(others):
        return None
    mean, spread = readings.mean(axis=0), readings.std(axis=0)
    matrix = np.column_stack(
        (np.ones(len(readings)), (readings[:, others] - mean[others]) / spread[others])
    )
    values = (readings[:, channel] - mean[channel]) / spread[channel]
    living = ~_flat(readings, noise, channel, near)
    if living.mean() < LEAST_OUTSIDE:
        living[:] = True
    parts = [
        part
        for part in _stretches(matrix, values, living)
        if _stirred(readings[:, near], part, noise[near])
    ]
    outside = living & _outside(parts, len(values))
    solution, left = _law(matrix, values, outside)
    expected = matrix @ solution
    compared = [_all_of(expected[part], values[part]) for part in parts]
    sure = [
        _throughout(
            expected[part], values[part], left, SURE_STDS * _error(matrix[part], matrix[outside])
        )
        for part in parts
    ]
    if not any(sure):
        return None
    still = ~_outside(list(compress(parts, sure)), len(values))
    clearest = max(compress(compared, sure), key=lambda one: float(one.motion[0]))
    law = np.zeros(1 + readings.shape[1])
    law[[1 + one for one in others]] = spread[channel] * solution[1:] / spread[others]
    law[0] = mean[channel] + spread[channel] * solution[0] - law[1:] @ mean
    return StuckBlocks(
        channel,
        still,
        law[0] + readings @ law[1:],
        1.0 - float(clearest.follows[0]),
        law,
        float(clearest.stuck[0] / clearest.lawful[0]),
    )


@dataclass(frozen=True)
class _Compared:
    """What law and stuck reading leave in each of p stretches, (p,) mean squares of its blocks.

    Attributes:
        count: blocks.
        follows: share of the expected motion that is shown.
        motion: variance of the expected motion.
        lawful: left by the law.
        stuck: left by a constant and that share of the expected motion.
    """

    count: FloatArray
    follows: FloatArray
    motion: FloatArray
    lawful: FloatArray
    stuck: FloatArray

    def sure(self, left: float, stds: float) -> BoolArray:
        """(p,) stretches in which the channel is stuck.

        Args:
            left: standard deviation of what the law leaves outside.
            stds: of the expected motion in it, at least.
        """
        sure: BoolArray = (
            (np.abs(self.follows) < FOLLOWS)
            & (self.motion > (stds * left) ** 2)
            & (self.stuck < BROKEN * self.lawful)
            & (self.stuck < (STILL_STDS * left) ** 2)
        )
        return sure

    def unplugged(self, left: float, stds: float) -> bool:
        """Whether the channel stays at a level that is not its own in the first stretch.

        Then it need not be missed by as much motion.
        """
        far = self.lawful[0] > (AWAY * stds * left) ** 2
        moves = self.motion[0] > (SUSPECT_STDS * left) ** 2
        return bool(far and moves and self.stuck[0] < CONSTANT**2 * self.motion[0])


def _compare(
    count: FloatArray,
    expected: FloatArray,
    expected2: FloatArray,
    product: FloatArray,
    values: FloatArray,
    values2: FloatArray,
) -> _Compared:
    """From sums over each stretch (p,): of both, of their squares, and of their product."""
    motion = np.maximum(expected2 / count - (expected / count) ** 2, 1e-12)
    together = product / count - expected * values / count**2
    scatter = values2 / count - (values / count) ** 2
    return _Compared(
        count,
        together / motion,
        motion,
        (values2 - 2.0 * product + expected2) / count,
        np.maximum(scatter - together**2 / motion, 0.0),
    )


def _compared(
    expected: FloatArray, values: FloatArray, first: IntArray, end: IntArray
) -> _Compared:
    """Stretches of blocks from `first` (p,) to before `end` (p,)."""
    columns = (np.ones_like(values), expected, expected**2, expected * values, values, values**2)
    summed = np.cumsum(np.concatenate((np.zeros((6, 1)), np.stack(columns)), axis=1), axis=1)
    return _compare(*(summed[:, end] - summed[:, first]))


def _all_of(expected: FloatArray, values: FloatArray) -> _Compared:
    """One stretch of these blocks alone."""
    return _compared(expected, values, np.array([0]), np.array([len(values)]))


def _error(inside: FloatArray, outside: FloatArray) -> float:
    """Standard deviation of a law's error in a stretch, in that of what it leaves outside.

    A law says little of motion that the blocks it was fitted to do not have.
    """
    normal = outside.T @ outside + RIDGE * len(outside) * np.eye(outside.shape[1])
    moved = inside - inside.mean(axis=0)
    leverage = float(np.sum(moved * np.linalg.solve(normal, moved.T).T)) / len(inside)
    return float(np.sqrt(1.0 + CORRELATED * leverage))


def _flat(readings: FloatArray, noise: FloatArray, channel: int, near: Sequence[int]) -> BoolArray:
    """(T,) blocks of windows in which a channel hardly moves while its neighbours do."""
    flat = np.zeros(len(readings), dtype=bool)
    if len(readings) < WINDOW:
        return flat
    own = [channel, *near]
    windows = sliding_window_view(readings[:, own], WINDOW, axis=0)
    moved = np.maximum(np.ptp(windows, axis=-1) - NOISE_RANGE * noise[own], 0.0)
    moved /= np.ptp(readings[:, own], axis=0)
    share = np.median(moved[:, 1:], axis=1)
    for start in np.flatnonzero((share > STIR_SHARE) & (moved[:, 0] < FLAT_SHARE * share)):
        flat[start : start + WINDOW] = True
    return flat


def _stirred(readings: FloatArray, part: IntArray, noise: FloatArray) -> bool:
    """Whether one of a channel's neighbours (T, m) moves in a stretch for more than a moment.

    Where a foot hangs, none does, but for blocks in which it leaves the floor and touches it.
    """
    away = np.abs(readings[part] - np.median(readings[part], axis=0))
    moved = away > STIR_SHARE * np.ptp(readings, axis=0) + NOISE_RANGE * noise
    return bool(np.max(moved.mean(axis=0)) > STIRRED)


def _throughout(expected: FloatArray, values: FloatArray, left: float, stds: float) -> bool:
    """A stretch is a stuck one as a whole and without any quarter; and in none of them it follows.

    A jolt, or one foot that is put down, is a single motion to which any share of it fits.
    """
    quarters = np.array_split(np.arange(len(values)), 4)
    rest = [np.delete(np.arange(len(values)), quarter) for quarter in quarters]
    whole = _all_of(expected, values)
    if whole.stuck[0] > STILL_SHARE**2 * whole.motion[0]:
        return False
    stuck = all(_all_of(expected[one], values[one]).sure(left, stds)[0] for one in rest)
    parts = [_all_of(expected[one], values[one]) for one in quarters]
    still = whole.unplugged(left, stds) or (stuck and bool(whole.sure(left, stds)[0]))
    return still and not any(
        one.motion[0] > (stds * left) ** 2 and abs(one.follows[0]) > FOLLOWS for one in parts
    )


def _stretches(matrix: FloatArray, values: FloatArray, living: BoolArray) -> list[IntArray]:
    """Blocks of each stretch in which the channel may be stuck, by their indices.

    Args:
        living: (T,) blocks to which laws are fitted.
    """
    rows, found = np.arange(len(values)), []
    for _ in range(MOST_STRETCHES):
        part = _stretch(matrix[rows], values[rows], living[rows])
        if part is None or len(rows) - (part.stop - part.start) < LEAST_OUTSIDE * len(values):
            break
        found.append(rows[part])
        rows = np.delete(rows, part)
    return found


def _stretch(matrix: FloatArray, values: FloatArray, living: BoolArray) -> slice | None:
    """The one whose law is best, be the channel stuck for little of the time or for most of it."""
    everything = np.ones(len(values), dtype=bool)
    found = [
        one
        for outside in (everything, _roughly(matrix, values))
        if (one := _settled(matrix, values, living, outside)) is not None
    ]
    return min(found, key=lambda one: one[0])[1] if found else None


def _roughly(matrix: FloatArray, values: FloatArray) -> BoolArray:
    """(T,) blocks outside the stretch that leaves least, each with its own law."""
    first, end = _pairs(len(values), COARSE)
    normal, right, square = (
        np.concatenate((np.zeros((1, *one.shape[1:])), np.cumsum(one, axis=0)))
        for one in (matrix[:, :, None] * matrix[:, None, :], matrix * values[:, None], values**2)
    )
    inside = normal[end] - normal[first], right[end] - right[first], square[end] - square[first]
    ridge = RIDGE * len(values) * np.eye(matrix.shape[1])
    solution = np.linalg.solve(normal[-1] - inside[0] + ridge, (right[-1] - inside[1])[:, :, None])
    solution = solution[:, :, 0]
    compared = _compare(
        (end - first).astype(np.float64),
        np.sum(inside[0][:, 0] * solution, axis=1),
        np.einsum("pi,pij,pj->p", solution, inside[0], solution),
        np.sum(inside[1] * solution, axis=1),
        inside[1][:, 0],
        inside[2],
    )
    outside = square[-1] - inside[2] - np.sum((right[-1] - inside[1]) * solution, axis=1)
    left = np.where(
        np.abs(compared.follows) < FOLLOWS, outside + compared.count * compared.stuck, np.inf
    )
    least = int(np.argmin(left))
    return _outside([np.arange(first[least], end[least])], len(values))


def _settled(
    matrix: FloatArray, values: FloatArray, living: BoolArray, outside: BoolArray
) -> tuple[float, slice] | None:
    """What the law leaves, and the stretch that explains most, from an idea of what is outside."""
    everywhere = _pairs(len(values), FINE)
    part = slice(0, 0)
    for step in range(ROUNDS + EXACT_ROUNDS):
        if np.count_nonzero(living & outside) < 2 * matrix.shape[1]:
            return None
        first, end = everywhere if step < ROUNDS else _around(part, len(values))
        solution, left = _law(matrix, values, living & outside)
        compared = _compared(matrix @ solution, values, first, end)
        gain = compared.count * (compared.lawful - compared.stuck)
        suspect = compared.sure(left, SUSPECT_STDS) & (compared.count >= LEAST_BLOCKS)
        gain[~suspect] = 0.0
        best = int(np.argmax(gain))
        if gain[best] <= 0.0:
            return None
        part = slice(int(first[best]), int(end[best]))
        outside = _outside([np.arange(part.start, part.stop)], len(values))
    return left, part


def _pairs(count: int, moments: int) -> tuple[IntArray, IntArray]:
    """Stretches between some moments that leave enough outside."""
    at = np.unique(np.linspace(0, count, moments + 1).astype(np.int64))
    first, end = np.triu_indices(len(at), 1)
    few = at[end] - at[first] <= (1.0 - LEAST_OUTSIDE) * count
    return at[first[few]], at[end[few]]


def _around(part: slice, count: int) -> tuple[IntArray, IntArray]:
    """Stretches that start and end near those of one found at the moments of `FINE`."""
    reach = np.arange(-(count // FINE) - 1, count // FINE + 2)
    first, end = np.meshgrid(part.start + reach, part.stop + reach)
    inside = (first >= 0) & (end <= count) & (first < end)
    return first[inside], end[inside]


def _law(matrix: FloatArray, values: FloatArray, outside: BoolArray) -> tuple[FloatArray, float]:
    """The law by the blocks outside, and the standard deviation of what it leaves of them."""
    rows, wanted = matrix[outside], values[outside]
    normal = rows.T @ rows + RIDGE * len(values) * np.eye(matrix.shape[1])
    solution = np.asarray(np.linalg.solve(normal, rows.T @ wanted), dtype=np.float64)
    return solution, float(np.sqrt(np.mean((wanted - rows @ solution) ** 2)))


def _outside(parts: Sequence[IntArray], count: int) -> BoolArray:
    outside = np.ones(count, dtype=bool)
    for part in parts:
        outside[part] = False
    return outside
