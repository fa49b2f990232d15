"""Rescuing what is whole in a cut or damaged run file."""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import MAGIC_SIZE, StreamReader

from shoecal_core.files import read_bytes
from shoecal_core.recording import schemas
from shoecal_core.recording.container import (
    DAMAGE,
    MAX_CHUNK,
    MAX_DATA,
    MAX_RECORDS,
    check_channel,
    looks_like_mcap,
    unfold,
)
from shoecal_core.recording.errors import DamagedError, RecordingError
from shoecal_core.recording.info import RECORD, RunInfo
from shoecal_core.recording.writer import MAX_TIME_NS, PART, RunWriter

_RECORD_HEADER = struct.Struct("<BQ")  # opcode, length
_COMPRESSION = struct.pack("<I", 4) + b"zstd"
_BEFORE_COMPRESSION = _RECORD_HEADER.size + 28  # times, size and checksum stand before it
_METADATA = struct.pack("<I", len(RECORD)) + RECORD.encode()
_MAX_METADATA = 2**16
_FOOTER_SIZE = 20
_CRC_SIZE = 4
_MAX_INDEX = 100_000
"""Records of an index; it has one or two of each chunk."""
_READABLE = 0.95
"""Of what a run may hold, so much is rescued at most: its own index comes on top."""
_DATA_END = _RECORD_HEADER.pack(Opcode.DATA_END, _CRC_SIZE)
_BETWEEN = (Opcode.HEADER, Opcode.METADATA, Opcode.MESSAGE_INDEX)
"""Records that stand between a file's chunks."""
_TOPICS = {**schemas.RUN_TOPICS, **schemas.TRUTH_TOPICS}


@dataclass(frozen=True)
class RecoveryReport:
    """What was rescued and what was lost.

    Attributes:
        path: the damaged file, left as it is.
        out: the file made from it.
        info: what the run says of itself.
        messages: rescued, by topic.
        start_ns, end_ns: log time of the first and the last message rescued.
        holes_ns: spans of log time between whole chunks where the file is damaged.
        whole_end: the recording's own end was found; otherwise it went on after `end_ns`.
    """

    path: Path
    out: Path
    info: RunInfo
    messages: dict[str, int]
    start_ns: int
    end_ns: int
    holes_ns: tuple[tuple[int, int], ...]
    whole_end: bool

    def __str__(self) -> str:
        counts = ", ".join(f"{count} {topic}" for topic, count in sorted(self.messages.items()))
        lines = [f"{self.out}: {(self.end_ns - self.start_ns) / 1e9:.2f} s rescued ({counts})"]
        for begin, end in self.holes_ns:
            at, span = (begin - self.start_ns) / 1e9, (end - begin) / 1e9
            lines.append(f"damaged: {span:.2f} s at {at:.2f} s; messages within may be lost")
        if not self.whole_end:
            lines.append("lost: the end of the recording")
        return "\n".join(lines)


@dataclass(frozen=True)
class _Part:
    """One whole chunk: its place in the file, its size when unfolded [bytes] and its records."""

    start: int
    stop: int
    size: int
    records: list[McapRecord]


def recovered_path(path: Path) -> Path:
    """Where to put what is rescued: an unfinished run under its own name, else next to it."""
    path = Path(path)
    whole = path.with_suffix("") if path.suffix == PART else path
    return whole if path != whole and not whole.exists() else whole.with_suffix(".recovered.mcap")


def recover(path: Path, out: Path) -> RecoveryReport:
    """Write every whole chunk of a cut or damaged file as a run file of its own.

    Args:
        path: the damaged file; it is not changed.
        out: the file to make; must not exist.

    Raises:
        RecordingError: nothing can be rescued.
        FileTakenError: `out` exists.
        FileError: `path` cannot be read, or `out` not be written.
    """
    path, out = Path(path), Path(out)
    data = read_bytes(path)
    info = _info(path, data)
    parts = list(_whole_chunks(data))
    found = _messages(path, data, parts)
    if not found:
        raise RecordingError(path, "holds no whole chunk of messages; nothing can be rescued")
    # Not the usual suffix: that may be the name of the damaged file itself.
    writer = RunWriter(out, info, topics=_TOPICS, suffix=".recovering")
    try:
        for topic, message in found:
            writer.write(topic, message.data, message.log_time)
        writer.close()
    finally:
        writer.part.unlink(missing_ok=True)  # a half-made copy is of no use
    times = [message.log_time for _, message in found]
    holes, whole_end = _holes(data, parts)
    return RecoveryReport(
        path=path,
        out=out,
        info=info,
        messages=dict(Counter(topic for topic, _ in found)),
        start_ns=min(times),
        end_ns=max(times),
        holes_ns=tuple(holes),
        whole_end=whole_end,
    )


def _info(path: Path, data: bytes) -> RunInfo:
    """The metadata record, found wherever it is; its own checksum vouches for it."""
    at = data.find(_METADATA)
    while at >= 0:
        with suppress(DamagedError, *DAMAGE):
            record = Metadata.read(ReadDataStream(BytesIO(data[at : at + _MAX_METADATA])))
            return RunInfo.from_metadata(path, record.metadata)
        at = data.find(_METADATA, at + 1)
    kind = "its" if looks_like_mcap(data) else "is no MCAP file, or its"
    raise RecordingError(path, f"{kind} record '{RECORD}' is lost or altered; cannot be rescued")


def _whole_chunks(data: bytes) -> Iterator[_Part]:
    """Chunks that pass their checksum, wherever they stand: no length on the way is trusted."""
    at, size, count = data.find(_COMPRESSION), 0, 0
    while at >= 0:
        start = at - _BEFORE_COMPRESSION
        part = _chunk(data, start) if start >= 0 else None
        if part is not None:
            size, count = size + part.size, count + len(part.records)
            # What cannot be read afterwards need not be rescued either.
            if size > _READABLE * MAX_DATA or count > _READABLE * MAX_RECORDS:
                return
            yield part
        at = data.find(_COMPRESSION, at + 1 if part is None else part.stop)


def _chunk(data: bytes, start: int) -> _Part | None:
    opcode, length = _RECORD_HEADER.unpack_from(data, start)
    begin, stop = start + _RECORD_HEADER.size, start + _RECORD_HEADER.size + length
    if opcode != Opcode.CHUNK or length > MAX_CHUNK or stop > len(data):
        return None
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(data[begin:stop])))
        if chunk.uncompressed_crc == 0:
            return None
        records = unfold(chunk)
    except DAMAGE:
        return None
    if any(isinstance(record, Message) and record.log_time > MAX_TIME_NS for record in records):
        return None  # no clock has that time
    return _Part(start, stop, chunk.uncompressed_size, records)


def _messages(path: Path, data: bytes, parts: list[_Part]) -> list[tuple[str, Message]]:
    """Messages of known channels. The index repeats the channels of chunks that are lost."""
    records = [record for part in parts for record in part.records]
    types: dict[int, Schema] = {}
    topics: dict[int, str] = {}
    for record in [*_index(data), *records]:
        if isinstance(record, Schema):
            types[record.id] = record
        elif isinstance(record, Channel) and record.topic in _TOPICS:
            check_channel(path, record, types.get(record.schema_id), _TOPICS)
            topics[record.id] = record.topic
    return [
        (topics[record.channel_id], record)
        for record in records
        if isinstance(record, Message) and record.channel_id in topics
    ]


def _index(data: bytes) -> list[McapRecord]:
    """Records of the index at the file's end; none where it is lost or altered."""
    begin = data.rfind(_DATA_END) + len(_DATA_END) + _CRC_SIZE
    footer_at = len(data) - MAGIC_SIZE - _FOOTER_SIZE
    try:
        footer = Footer.read(ReadDataStream(BytesIO(data[footer_at:])))
        if footer.summary_crc != zlib.crc32(data[begin : footer_at + _FOOTER_SIZE - _CRC_SIZE]):
            return []
        # The file's end may be made up, too: of chunks there are none in an index.
        reader = StreamReader(BytesIO(data[begin:]), skip_magic=True, emit_chunks=True)
        return list(islice(reader.records, _MAX_INDEX))
    except DAMAGE:
        return []


def _holes(data: bytes, parts: list[_Part]) -> tuple[list[tuple[int, int]], bool]:
    """Where something stood between the whole chunks, and whether nothing followed them."""
    holes = []
    expected, opcode = _next_part(data, MAGIC_SIZE)
    before: int | None = None
    damaged = False
    for part in parts:
        damaged = damaged or part.start != expected
        expected, opcode = _next_part(data, part.stop)
        times = [record.log_time for record in part.records if isinstance(record, Message)]
        if not times:
            continue  # schemas and channels alone: the hole ends with the next message
        if damaged:
            holes.append((min(times) if before is None else before, min(times)))
        before, damaged = max(times), False
    return holes, opcode == Opcode.DATA_END


def _next_part(data: bytes, at: int) -> tuple[int, int]:
    """Place and opcode of the next chunk or end of data, over records that hold no messages."""
    while at + _RECORD_HEADER.size <= len(data):
        opcode, length = _RECORD_HEADER.unpack_from(data, at)
        if opcode == Opcode.CHUNK or data.startswith(_DATA_END, at):
            return at, int(opcode)
        if opcode not in _BETWEEN:
            break
        at += _RECORD_HEADER.size + length
    return len(data), 0
