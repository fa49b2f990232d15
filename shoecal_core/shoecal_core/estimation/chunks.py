"""Samples of long recordings are worked on a chunk at a time: the memory stays bounded."""

from __future__ import annotations

from collections.abc import Iterator

CHUNK = 4096
"""Samples of one chunk: what is computed from them stays within a core's cache."""


def chunks(count: int) -> Iterator[slice]:
    """Slices that cover `count` samples in order."""
    return (slice(start, start + CHUNK) for start in range(0, count, CHUNK))
