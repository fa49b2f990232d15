"""Many messages of one layout at once: simulated sessions would else spend their time on them."""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording.messages import SECOND_NS

FloatArray = NDArray[np.float64]
Stamps = NDArray[np.int64]

_SECONDS, _NANOSECONDS = 0x12345678, 0x1234567
"""Of a stamp that marks its place in a message."""


def series(
    one: Callable[[int, FloatArray], bytes], stamps: Stamps, values: FloatArray
) -> list[bytes]:
    """Messages that differ in their stamp and in numbers alone.

    One message is made with numbers that occur nowhere else; where they stand in its bytes, those
    of all others stand too.

    Args:
        one: makes a message (CDR, little endian) of a stamp [ns] and numbers (k,), each of which
            it writes once, as a float64.
        stamps: (T,) [ns].
        values: (T, k).

    Raises:
        ShapeError: when there are more or fewer rows than stamps.
        ShoecalError: for a stamp that cannot be recorded, or a `one` that keeps to something else.
    """
    if values.ndim != 2 or len(values) != len(stamps):
        raise ShapeError("values", f"({len(stamps)}, k)", values.shape)
    if not len(stamps):
        return []
    if stamps.min() < 0 or stamps.max() >= 2**31 * SECOND_NS:
        raise ShoecalError(f"stamps {stamps.min()} to {stamps.max()} ns: must be 0 to 2^31 s")
    marks: FloatArray = np.pi * 1e7 + np.arange(values.shape[1], dtype=np.float64)
    template = one(_SECONDS * SECOND_NS + _NANOSECONDS, marks)
    rows = np.tile(np.frombuffer(template, dtype=np.uint8), (len(stamps), 1))
    seconds, nanoseconds = np.divmod(stamps, SECOND_NS)
    place = _place(template, struct.pack("<iI", _SECONDS, _NANOSECONDS))
    rows[:, place : place + 8] = _bytes(np.stack((seconds, nanoseconds), axis=1).astype("<u4"))
    for mark, column in zip(marks.tolist(), values.T, strict=True):
        place = _place(template, struct.pack("<d", mark))
        rows[:, place : place + 8] = _bytes(column.astype("<f8"))
    return [row.tobytes() for row in rows]


def _bytes(values: NDArray[np.generic]) -> NDArray[np.uint8]:
    """(T, 8) bytes of eight-byte rows."""
    return np.ascontiguousarray(values).view(np.uint8).reshape(len(values), 8)


def _place(template: bytes, mark: bytes) -> int:
    """Where the one occurrence of a mark begins."""
    if template.count(mark) != 1:
        raise ShoecalError("a message of a series must hold its stamp and each number once")
    return template.index(mark)
