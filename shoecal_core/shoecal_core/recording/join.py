"""Joining messages that carry different columns of one sampling time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Piece:
    """Samples of some columns.

    Attributes:
        stamp_ns: (k,) increasing.
        columns: (c,) which columns of the whole they are.
        values: (k, c) by quantity.
    """

    stamp_ns: NDArray[np.int64]
    columns: NDArray[np.int64]
    values: dict[str, NDArray[np.float64]]


class TwoSourcesError(Exception):
    """Two pieces give one column at one time.

    Attributes:
        column: the first such column.
        stamp_ns: the first such time.
    """

    def __init__(self, column: int, stamp_ns: int) -> None:
        self.column = column
        self.stamp_ns = stamp_ns
        super().__init__(f"column {column} is given twice at {stamp_ns} ns")


def in_order(stamp_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(k,) which samples are later than every one before them."""
    before = np.maximum.accumulate(stamp_ns)[:-1]
    return np.concatenate([np.ones(min(1, len(stamp_ns)), dtype=bool), stamp_ns[1:] > before])


def join(
    pieces: Sequence[Piece], width: int, quantities: Sequence[str]
) -> tuple[NDArray[np.int64], dict[str, NDArray[np.float64]]]:
    """Put pieces together by equal stamps.

    Returns:
        Stamps (T,), and each quantity (T, width), NaN where no piece gives it.

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
            raise TwoSourcesError(int(piece.columns[column]), int(piece.stamp_ns[row]))
        given[cells] = True
        for name, values in piece.values.items():
            joined[name][cells] = values
    return stamps, joined
