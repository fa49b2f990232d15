"""Joining samples of several sources: of one clock by their stamps, of several by interpolation."""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording.align import bracket

LINEAR = ("value", "temperature")
MAX_GAP_S = 0.1
MAX_GAP_PERIODS = 2.5
"""Readings are interpolated between samples that are no further apart than the larger of these."""
FEW_DIGITS_SHARE = 0.4
"""Of stamps that repeat the one before, and none goes back: their digits are missing."""
COMMON_SHARE = 0.5
"""Sources that share more of their stamps than this were sampled together."""


@dataclass(frozen=True)
class Piece:
    """Samples of some columns.

    Attributes:
        stamp_ns: (k,) increasing.
        columns: (c,) which columns of the whole they are.
        values: (k, c) by quantity.
    """

    stamp_ns: IntArray
    columns: IntArray
    values: dict[str, FloatArray]


class OverlapError(Exception):
    """Two pieces give one column at one time.

    Attributes:
        column: the first such column.
        stamp_ns: the first such time.
    """

    def __init__(self, column: int, stamp_ns: int) -> None:
        self.column = column
        self.stamp_ns = stamp_ns
        super().__init__(f"column {column} is given twice at {stamp_ns} ns")


def few_digits(stamps: IntArray) -> bool:
    """Whether stamps (T,) [ns] are rounded so far that many in a row are one."""
    steps = np.diff(stamps)
    return bool((steps == 0).sum() > FEW_DIGITS_SHARE * len(stamps) and (steps >= 0).all())


def two_orders(
    groups: Sequence[tuple[Sequence[str], IntArray]],
) -> tuple[str, tuple[Sequence[str], Sequence[str]]] | None:
    """A name that two senders send in turns, and their lists of names; None without one.

    One sender lists its names in one order, whichever of them it leaves out now and then.

    Args:
        groups: lists of names, each with the stamps (k,) of its messages [ns].
    """
    for (one, stamps), (other, others) in itertools.combinations(groups, 2):
        shared = [name for name in one if name in other]
        if [name for name in other if name in shared] == shared:
            continue
        turns = np.argsort(np.concatenate([stamps, others]), kind="stable") < len(stamps)
        if np.count_nonzero(turns[1:] != turns[:-1]) > 1:
            return shared[0], (one, other)
    return None


def two_orders_text(name: str, lists: tuple[Sequence[str], Sequence[str]]) -> str:
    """The error for what `two_orders` finds."""
    one, other = (f"{', '.join(names[:3])}, …" for names in lists)
    return (
        f"two senders send '{name}' in turns, one as ({one}), the other as ({other}); record one "
        "of them"
    )


def in_order(stamp_ns: IntArray) -> BoolArray:
    """(k,) mask of samples to keep: as many as can be whose stamps (k,) [ns] increase.

    So one stamp far ahead is left out, not all that follow it.
    """
    kept = np.ones(len(stamp_ns), dtype=bool)
    if (np.diff(stamp_ns) > 0).all():
        return kept
    # Longest increasing subsequence (patience sorting): of every length the one that ends first.
    ends: list[int] = []
    places: list[int] = []
    before = np.full(len(stamp_ns), -1)
    for place, stamp in enumerate(stamp_ns.tolist()):
        length = bisect_left(ends, stamp)
        if length < len(ends) and ends[length] == stamp:
            continue  # of several with one stamp the first
        before[place] = places[length - 1] if length else -1
        ends[length : length + 1] = [stamp]
        places[length : length + 1] = [place]
    kept[:] = False
    place = places[-1]
    while place >= 0:
        kept[place] = True
        place = int(before[place])
    return kept


def join(
    pieces: Sequence[Piece], width: int, quantities: Sequence[str]
) -> tuple[IntArray, dict[str, FloatArray]]:
    """Put pieces together by equal stamps.

    Returns:
        Stamps (T,) [ns], and each quantity (T, width), NaN where no piece has it.

    Raises:
        TwoSourcesError: when a column is given twice at one time.
    """
    stamps = np.unique(np.concatenate([piece.stamp_ns for piece in pieces]))
    given = np.zeros((len(stamps), width), dtype=bool)
    joined = {name: np.full((len(stamps), width), np.nan) for name in quantities}
    for piece in pieces:
        cells = np.ix_(np.searchsorted(stamps, piece.stamp_ns), piece.columns)
        if given[cells].any():
            row, column = np.argwhere(given[cells])[0]
            raise OverlapError(int(piece.columns[column]), int(piece.stamp_ns[row]))
        given[cells] = True
        for name, values in piece.values.items():
            joined[name][cells] = values
    return stamps, joined


def sampled_apart(sources: Sequence[Sequence[Piece]]) -> bool:
    """Whether the sources have their own sampling instants: most stamps of one are nowhere else."""
    if len(sources) < 2:
        return False
    stamps = [np.concatenate([piece.stamp_ns for piece in pieces]) for pieces in sources]
    fewest = min(stamps, key=len)
    return any(
        np.isin(fewest, other).mean() < COMMON_SHARE for other in stamps if other is not fewest
    )


def at_common_instants(
    sources: Sequence[Sequence[Piece]], width: int, quantities: Sequence[str]
) -> list[Piece]:
    """Pieces of all sources at the stamps of the source with the fewest samples.

    Between two samples values and temperatures are interpolated by their stamps, a status is the
    larger of the two, a counter that of the sample before. All are NaN in gaps and outside a
    source's own time.

    Args:
        sources: pieces by source.
        width: n columns of the whole.
        quantities: of the pieces, each (k, c).
    """
    joined = [join(pieces, width, quantities) for pieces in sources]
    wanted = min((stamps for stamps, _ in joined), key=len)
    pieces = []
    for own, (stamps, values) in zip(sources, joined, strict=True):
        columns = np.unique(np.concatenate([piece.columns for piece in own]))
        numbers = {name: values[name][:, columns] for name in quantities}
        pieces.append(Piece(wanted, columns, _resampled(stamps, numbers, wanted)))
    return pieces


def _resampled(
    stamps: IntArray, values: Mapping[str, FloatArray], wanted: IntArray
) -> dict[str, FloatArray]:
    """Values (k, c) of stamps (k,) [ns] at wanted stamps (T,) [ns]: (T, c)."""
    time, times = 1e-9 * (stamps - stamps[0]), 1e-9 * (wanted - stamps[0])
    period = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    around = bracket(time, times, max(MAX_GAP_S, MAX_GAP_PERIODS * period))
    found = {}
    for name, numbers in values.items():
        if name in LINEAR:
            found[name] = around.interpolate(numbers)
            continue
        before, after = numbers[around.before], numbers[around.after]
        held = np.maximum(before, after) if name == "status" else before
        found[name] = np.where(around.valid[:, None], held, np.nan)
    return found
