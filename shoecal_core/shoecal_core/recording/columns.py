"""Decoding many CDR messages of one type at once, into arrays.

Messages of one topic mostly share their layout: same names, same counts, so every number is
at the same place. The layout is found in one message, compared in all, and the numbers are
cut out as columns.
"""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import FieldDesc

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.schemas import typestore

_HEADER = 4
"""Bytes of the encapsulation header; CDR aligns from behind it."""

_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Block:
    """Messages of one layout.

    Attributes:
        index: (k,) places in the sequence that was decoded, ascending.
        texts: strings by dotted field path; a single string is a tuple of one.
        numbers: (k, count) by dotted field path.
    """

    index: IntArray
    texts: Mapping[str, tuple[str, ...]]
    numbers: Mapping[str, FloatArray]

    @property
    def stamp_ns(self) -> IntArray:
        """(k,) header stamps [ns]; zero where the sender set none."""
        sec = self.numbers["header.stamp.sec"][:, 0].astype(np.int64)
        nanosec = self.numbers["header.stamp.nanosec"][:, 0].astype(np.int64)
        return sec * _NANOSECONDS + nanosec

    @property
    def frame_id(self) -> str:
        """Of the header."""
        return self.texts["header.frame_id"][0]

    def group(self, *paths: str) -> FloatArray:
        """(k, c) numbers of several fields, column by column."""
        return np.hstack([self.numbers[path] for path in paths])

    def take(self, rows: BoolArray) -> Block:
        """Those of the messages that a mask (k,) chooses."""
        numbers = {path: values[rows] for path, values in self.numbers.items()}
        return Block(self.index[rows], self.texts, numbers)


def decode_columns(type_name: str, messages: Sequence[bytes]) -> list[Block]:
    """Decode messages of one type, grouped by layout.

    Bytes behind a message's end are ignored: some serialisers leave padding there.

    Raises:
        ShoecalError: for bytes that are no message of this type.
    """
    by_length: dict[int, list[int]] = defaultdict(list)
    for place, message in enumerate(messages):
        by_length[len(message)].append(place)
    blocks = []
    for length, places in by_length.items():
        joined = b"".join(messages[place] for place in places)
        rows = np.frombuffer(joined, dtype=np.uint8).reshape(len(places), length)
        index = np.array(places)
        while len(rows):
            layout = _Layout(type_name, rows[0].tobytes())
            same = (rows[:, layout.key] == rows[0, layout.key]).all(axis=1)
            blocks.append(Block(index[same], layout.texts, layout.cut(rows[same])))
            rows, index = rows[~same], index[~same]
    return blocks


@dataclass(frozen=True)
class _Field:
    start: int
    count: int
    dtype: np.dtype[np.generic]


class _Layout:
    """Where everything is in messages like one example.

    Attributes:
        texts: strings, which all such messages share.
        key: places of the bytes that make the layout: encapsulation, counts and strings.
    """

    def __init__(self, type_name: str, example: bytes) -> None:
        self.texts: dict[str, tuple[str, ...]] = {}
        self._fields: dict[str, _Field] = {}
        self._example = example
        self._at = _HEADER
        self._key = [slice(0, 2)]
        if example[:2] not in (b"\x00\x00", b"\x00\x01"):
            raise ShoecalError(f"not plain CDR, so not a {type_name}")
        self._order: Literal["<", ">"] = "<" if example[1] else ">"
        try:
            self._walk("", type_name)
        except (struct.error, UnicodeDecodeError, _ShortError) as error:
            raise ShoecalError(f"not a {type_name} ({error})") from error
        self.key = np.concatenate([np.arange(part.start, part.stop) for part in self._key])

    def cut(self, rows: NDArray[np.uint8]) -> dict[str, FloatArray]:
        """Numbers of messages (k, bytes) that share this layout."""
        numbers = {}
        for path, field in self._fields.items():
            stop = field.start + field.count * field.dtype.itemsize
            cells = np.ascontiguousarray(rows[:, field.start : stop]).reshape(-1)
            values = cells.view(field.dtype).astype(np.float64)
            numbers[path] = values.reshape(len(rows), field.count)
        return numbers

    def _walk(self, prefix: str, type_name: str) -> None:
        for name, kind in typestore().fielddefs[type_name][1]:
            self._take(f"{prefix}{name}", kind)

    def _take(self, path: str, kind: FieldDesc) -> None:
        if kind[0] == Nodetype.NAME:
            self._walk(f"{path}.", kind[1])
        elif kind[0] == Nodetype.BASE:
            self._take_base(path, kind[1][0], 1)
        else:
            element, length = kind[1]
            count = length if kind[0] == Nodetype.ARRAY else self._take_count()
            if element[0] != Nodetype.BASE:
                raise TypeError(f"{path}: sequences of messages have no columns")
            self._take_base(path, element[1][0], count)

    def _take_base(self, path: str, base: str, count: int) -> None:
        if base == "string":
            # At least five bytes each: a count gone wrong must not run for ever.
            self._need(5 * count)
            self.texts[path] = tuple(self._take_text() for _ in range(count))
            return
        name = {"byte": "uint8", "char": "uint8"}.get(base, base)
        dtype: np.dtype[np.generic] = np.dtype(name).newbyteorder(self._order)
        if count:
            self._align(dtype.itemsize)
        self._need(count * dtype.itemsize)
        self._fields[path] = _Field(self._at, count, dtype)
        self._at += count * dtype.itemsize

    def _take_count(self) -> int:
        self._align(4)
        (count,) = struct.unpack_from(f"{self._order}I", self._example, self._at)
        self._key.append(slice(self._at, self._at + 4))
        self._at += 4
        return int(count)

    def _take_text(self) -> str:
        length = self._take_count()
        self._need(length)
        raw = self._example[self._at : self._at + length]
        if not raw.endswith(b"\x00"):
            raise _ShortError("a string has no end")
        self._key.append(slice(self._at, self._at + length))
        self._at += length
        return raw[:-1].decode()

    def _align(self, size: int) -> None:
        self._at += -(self._at - _HEADER) % size

    def _need(self, size: int) -> None:
        if self._at + size > len(self._example):
            raise _ShortError(f"ends at byte {len(self._example)}")


class _ShortError(Exception):
    """A message is shorter than its counts say."""
