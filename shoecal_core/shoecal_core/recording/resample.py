"""Readings of several sources at common instants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.recording.join import Piece, join

Floats = NDArray[np.float64]

LINEAR = ("value", "temperature")
MAX_GAP_S = 0.1
MAX_GAP_PERIODS = 2.5
"""Readings are interpolated between samples that are no further apart than the larger of these."""
COMMON_SHARE = 0.5
"""Sources that share more of their stamps than this were sampled together."""


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
        pieces.append(Piece(wanted, columns, _interpolate(stamps, numbers, wanted)))
    return pieces


def _interpolate(
    stamps: NDArray[np.int64], values: Mapping[str, Floats], wanted: NDArray[np.int64]
) -> dict[str, Floats]:
    """Values (k, c) of stamps (k,) at wanted stamps (T,): (T, c)."""
    left = np.clip(np.searchsorted(stamps, wanted, side="right") - 1, 0, len(stamps) - 1)
    exact = stamps[left] == wanted
    right = np.where(exact, left, np.minimum(left + 1, len(stamps) - 1))
    gap = stamps[right] - stamps[left]
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    near = (gap > 0) & (gap <= max(MAX_GAP_S * 1e9, MAX_GAP_PERIODS * period))
    inside = exact | (near & (wanted > stamps[0]) & (wanted < stamps[-1]))
    fraction = np.where(exact, 0.0, (wanted - stamps[left]) / np.maximum(gap, 1))[:, None]
    found = {}
    for name, numbers in values.items():
        before, after = numbers[left], numbers[right]
        if name in LINEAR:
            between = before + fraction * (after - before)
        else:
            between = np.maximum(before, after) if name == "status" else before
        found[name] = np.where(inside[:, None], between, np.nan)
    return found
