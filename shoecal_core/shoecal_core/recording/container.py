"""Reading a run file whole, checksums and types included, before anything is made of it."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, cast

import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    Metadata,
    Schema,
)
from mcap.stream_reader import StreamReader, breakup_chunk

from shoecal_core.errors import FileTooLargeError
from shoecal_core.files import open_file, read_error
from shoecal_core.recording.errors import DamagedError, RecordingError, reason_of
from shoecal_core.recording.info import RECORD, RunInfo
from shoecal_core.recording.schemas import type_hash

DAMAGE = (
    McapError,
    zstandard.ZstdError,
    struct.error,
    ValueError,  # CRCValidationError and UnicodeDecodeError among them
    KeyError,
    IndexError,
    OverflowError,
    MemoryError,
    RuntimeError,
)
"""What the container's library raises on cut or altered bytes."""

MAX_CHUNK = 4 * 2**20
"""Bytes of one chunk when it is unfolded; writers make them of one mebibyte or less."""
MAX_DATA = 384 * 2**20
"""Bytes of a run's messages: some minutes at a thousand a second. Reading takes five times that."""
MAX_RECORDS = 500_000
"""Joints and voltages of four minutes at a thousand a second; taken apart within some seconds."""
MAGIC = b"\x89MCAP0\r\n"
"""Begins and ends a file."""
ZSTD = b"\x28\xb5\x2f\xfd"
PACKED = (ZSTD, b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"PK")
"""Begin files packed by zstd, gzip, bzip2, xz and zip."""
_ZSTD = "zstd"


@dataclass(frozen=True)
class Contents:
    """All messages of one file, as they were written.

    Attributes:
        path: the file.
        info: its metadata record.
        messages: CDR bytes by topic, in the order of the file.
        log_time_ns: when each was received, likewise.
    """

    path: Path
    info: RunInfo
    messages: Mapping[str, list[bytes]]
    log_time_ns: Mapping[str, list[int]]


def read_container(path: Path, topics: Mapping[str, str]) -> Contents:
    """Read every message of the given topics; other topics are left out.

    Raises:
        DamagedError: cut, unfinished, altered, or without checksums.
        RecordingError: not a run of shoecal, or a topic of another type.
        FileTooLargeError: more than fits into memory.
        FileMissingError, FileUnreadableError: cannot be opened or read.
        VersionError: written by a newer shoecal.
    """
    collected = _Collected(Path(path), topics)
    with _records(path) as records:
        for record in records:
            collected.add(record)
    return collected.contents()


def read_info(path: Path) -> RunInfo:
    """Read what a file says of itself, not its messages.

    Raises:
        FileError: as `read_container`, for the file's beginning.
    """
    with _records(path) as records:
        for record in records:
            if isinstance(record, Metadata) and record.name == RECORD:
                return RunInfo.from_metadata(path, record.metadata)
            if isinstance(record, Message | Footer):
                break
    raise _foreign(path)


class _Collected:
    """Records of one file put together."""

    def __init__(self, path: Path, topics: Mapping[str, str]) -> None:
        self._path = path
        self._topics = topics
        self._info: RunInfo | None = None
        self._ended = False
        self._names: dict[int, str] = {}
        self._schemas: dict[int, Schema] = {}
        self._messages: dict[str, list[bytes]] = defaultdict(list)
        self._log_time: dict[str, list[int]] = defaultdict(list)

    def add(self, record: McapRecord) -> None:
        """Take the next record.

        Raises:
            RecordingError: for a channel of another type.
            DamagedError: for data without a checksum.
        """
        if self._ended:  # only the index follows, which no checksum read here covers
            return
        if isinstance(record, Message):
            topic = self._names[record.channel_id]
            if topic in self._topics:
                self._messages[topic].append(record.data)
                self._log_time[topic].append(record.log_time)
        elif isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            check_channel(self._path, record, self._schemas.get(record.schema_id), self._topics)
            self._names[record.id] = record.topic
        elif isinstance(record, Metadata) and record.name == RECORD:
            self._info = RunInfo.from_metadata(self._path, record.metadata)
        elif isinstance(record, DataEnd):
            if record.data_section_crc == 0:
                raise DamagedError(self._path, "it carries no checksum of its data")
            self._ended = True

    def contents(self) -> Contents:
        """All that was taken.

        Raises:
            DamagedError: where the data's end was not among it.
            RecordingError: where the metadata record was not.
        """
        if not self._ended:
            raise DamagedError(self._path, "its data has no end")
        if self._info is None:
            raise _foreign(self._path)
        return Contents(self._path, self._info, dict(self._messages), dict(self._log_time))


def check_channel(
    path: Path, channel: Channel, schema: Schema | None, topics: Mapping[str, str]
) -> None:
    """Refuse a known topic of another type, another version of it or another encoding.

    Raises:
        RecordingError: naming file and topic.
    """
    kind = topics.get(channel.topic)
    if kind is None:
        return
    found = "no type" if schema is None else schema.name
    if found != kind or channel.message_encoding != "cdr":
        raise RecordingError(
            path,
            f"is {found} in {channel.message_encoding or 'no encoding'}, expected {kind} in cdr; "
            "record this topic with that type",
            field=channel.topic,
        )
    if channel.metadata.get("topic_type_hash") != type_hash(kind):
        raise RecordingError(
            path,
            f"was recorded with another definition of {kind}; convert it to the present one",
            field=channel.topic,
        )


def _foreign(path: Path) -> RecordingError:
    return RecordingError(
        path, f"has no metadata record '{RECORD}', so it is no run of shoecal; import it instead"
    )


def unfold(chunk: Chunk) -> list[McapRecord]:
    """Records of a chunk, its checksum tested.

    Raises:
        One of DAMAGE: for anything else than a chunk as it was written, before it is unfolded to
            more than it says of itself, or to more than MAX_CHUNK.
    """
    if chunk.compression not in (_ZSTD, ""):
        raise McapError(f"compression '{chunk.compression[:30]}' is not known here")
    if chunk.uncompressed_size > MAX_CHUNK:
        raise McapError(f"a chunk of {chunk.uncompressed_size} bytes")
    check_honest(chunk)
    return breakup_chunk(chunk, validate_crc=True)


def check_honest(chunk: Chunk) -> None:
    """Refuse a chunk that would be unfolded to another size than it says of itself.

    Raises:
        McapError: for such a one.
    """
    if chunk.compression == _ZSTD and zstandard.frame_content_size(chunk.data) not in (
        -1,  # unknown; the decompressor keeps to the size below
        chunk.uncompressed_size,
    ):
        raise McapError("a chunk that is larger than it says")


def looks_like_mcap(head: bytes) -> bool:
    """Whether a file that begins so is an MCAP file, perhaps cut or with a byte altered."""
    same = sum(one == other for one, other in zip(head, MAGIC, strict=False))
    return 2 * same >= min(len(head), len(MAGIC))


@contextmanager
def _records(path: Path) -> Iterator[Iterator[McapRecord]]:
    """Records of a file, its damages and refusals as typed errors."""
    path = Path(path)
    opened = open_file(path)
    try:
        with opened as file:
            head = file.read(len(MAGIC))
            if not looks_like_mcap(head):
                packed = any(head.startswith(one) for one in PACKED)
                cure = "is compressed as a whole: unpack it" if packed else "is no MCAP file"
                raise RecordingError(path, cure)
            file.seek(0)
            yield _checked(path, _unfolded(path, _Reader(file, path.stat().st_size).records))
    except DAMAGE as error:
        raise DamagedError(path, reason_of(error)) from error
    except OSError as error:
        raise read_error(path, error) from error


class _Reader(StreamReader):
    """Reads records one after the other, none beyond the file's end and not for ever."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        super().__init__(
            cast(BinaryIO, _Within(file, size)),
            emit_chunks=True,
            validate_crcs=True,
            record_size_limit=size,
        )
        self._seen = 0

    def _read_record(self, opcode: int, length: int) -> McapRecord | None:
        self._seen += 1
        if opcode == 0 or self._seen > MAX_RECORDS:
            raise McapError("zeros, or pieces without end, where records should be")
        if opcode == Opcode.MESSAGE_INDEX:  # Passed over: everything is read anyway.
            return None
        return super()._read_record(opcode, length)


class _Within:
    """A file that raises EndOfFile where more is asked for than it holds.

    A length gone wrong must not fill the memory.
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._left = file, size

    def read(self, length: int) -> bytes:
        if length > self._left:
            raise EndOfFile
        data = self._file.read(length)
        self._left -= len(data)
        return data


def _unfolded(path: Path, records: Iterator[McapRecord]) -> Iterator[McapRecord]:
    """Records with those of chunks in their chunks' place, as many as fit into memory."""
    size, count = 0, 0
    for record in records:
        inner = unfold(record) if isinstance(record, Chunk) else [record]
        size += record.uncompressed_size if isinstance(record, Chunk) else 0
        count += len(inner)
        if size > MAX_DATA or count > MAX_RECORDS:
            raise FileTooLargeError(
                path,
                f"holds more than {MAX_DATA >> 20} MiB or {MAX_RECORDS} messages; record "
                "shorter runs",
            )
        yield from inner


def _checked(path: Path, records: Iterator[McapRecord]) -> Iterator[McapRecord]:
    for place, record in enumerate(records):
        if place == 0 and not (isinstance(record, Header) and record.profile == "ros2"):
            raise RecordingError(path, "is no recording of ROS 2 (MCAP profile 'ros2')")
        yield record
