"""Mutants of MCAP files: of their bytes, of their records, and files that unfold into gigabytes.

Where records are changed, every length and checksum is made right again.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import NamedTuple

import zstandard

from reliability.mutations import Rng, mutate_bytes, pick

_MAGIC = b"\x89MCAP0\r\n"
_MESSAGE, _CHUNK, _DATA_END = 5, 6, 15
_CHUNK_HEAD = struct.calcsize("<QQQI") + struct.calcsize("<I4sQ")
"""Bytes before the content of a chunk: times, size, checksum; name and size of the compression."""


class Record(NamedTuple):
    """One record of MCAP."""

    opcode: int
    body: bytes

    @property
    def bytes(self) -> bytes:
        return struct.pack("<BQ", self.opcode, len(self.body)) + self.body


def mutate_records(whole: bytes, rng: Rng) -> bytes:
    """A mutant of which a record is changed, dropped, repeated or moved, mostly one in a chunk."""
    outer = _outer(whole)
    at = pick(rng, [at for at, record in enumerate(outer) if record.opcode == _CHUNK])
    if rng.random() < 0.3:
        return _file(_change(outer, rng))
    start, end, _, _ = struct.unpack_from("<QQQI", outer[at].body)
    packed = outer[at].body[_CHUNK_HEAD:]
    inner = _change(_records(zstandard.ZstdDecompressor().decompressobj().decompress(packed)), rng)
    outer[at] = _chunk(b"".join(record.bytes for record in inner), (start, end))
    return _file(outer)


def unfold(whole: bytes, rng: Rng) -> bytes:
    """A mutant with a chunk of little on the disk and much in memory."""
    outer = _outer(whole)
    empty = Record(_MESSAGE, struct.pack("<HIQQ", 1, 0, 5, 5)).bytes
    makers: tuple[Callable[[], list[Record]], ...] = (
        lambda: [_chunk(empty * 2**22)],
        lambda: [_chunk(empty * 2**17)] * 40,
        lambda: [_chunk(bytes(2**28))],
        lambda: [_chunk(bytes(2**27), size=100)],
        lambda: [_chunk(bytes(99), size=2**60)],
        lambda: [_chunk(bytes(2**27), size=100, sized=False)],
    )
    at = 1 + next(at for at, record in enumerate(outer) if record.opcode == _CHUNK)
    return _file([*outer[:at], *pick(rng, makers)(), *outer[at:]])


def _outer(whole: bytes) -> list[Record]:
    return _records(whole[len(_MAGIC) : -len(_MAGIC)])


def _records(data: bytes) -> list[Record]:
    found, at = [], 0
    while at < len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        found.append(Record(opcode, data[at + 9 : at + 9 + length]))
        at += 9 + length
    return found


def _change(records: list[Record], rng: Rng) -> list[Record]:
    at, other = (int(place) for place in rng.integers(len(records), size=2))
    one, changed = records[at], list(records)
    match int(rng.integers(6)):
        case 0:
            del changed[at]
        case 1:
            changed[at:at] = [one] * int(
                10 ** rng.uniform(0.0, 4.0 if len(one.body) < 200 else 0.5)
            )
        case 2:
            changed[at], changed[other] = changed[other], changed[at]
        case 3:
            changed[at] = Record(int(rng.integers(256)), one.body)
        case _:
            changed[at] = Record(one.opcode, mutate_bytes(one.body or b" ", rng))
    return changed


def _chunk(
    content: bytes, times: tuple[int, int] = (0, 5), size: int | None = None, *, sized: bool = True
) -> Record:
    """A chunk that declares a size of its content, which may be wrong or missing in the frame."""
    packed = zstandard.ZstdCompressor(write_content_size=sized).compress(content)
    declared = len(content) if size is None else size
    head = struct.pack("<QQQI", *times, declared, zlib.crc32(content))
    return Record(_CHUNK, head + struct.pack("<I4sQ", 4, b"zstd", len(packed)) + packed)


def _file(records: list[Record]) -> bytes:
    """A file of records whose data checksum is right."""
    parts, crc = [_MAGIC], zlib.crc32(_MAGIC)
    for record in records:
        ends = record.opcode == _DATA_END
        written = (Record(_DATA_END, struct.pack("<I", crc)) if ends else record).bytes
        parts.append(written)
        crc = zlib.crc32(written, crc)
    return b"".join([*parts, _MAGIC])
