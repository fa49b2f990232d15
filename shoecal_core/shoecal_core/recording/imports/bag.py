"""Bags of ROS 1 and ROS 2, opened by `rosbags`: topics, types and decoded messages."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any, Self

import yaml
import zstandard
from mcap.records import Chunk
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from shoecal_core.errors import (
    FileError,
    FileMissingError,
    FileSyntaxError,
    FileTooLargeError,
    FileUnreadableError,
    named_together,
)
from shoecal_core.files import open_file, read_bytes, read_error
from shoecal_core.recording.container import DAMAGE, ZSTD, check_honest
from shoecal_core.recording.errors import RecordingError, reason_of
from shoecal_core.recording.imports.bag_copies import (
    check_logs,
    merged,
    of_this_profile,
    stored,
    unmerged,
)
from shoecal_core.recording.schemas import typestore

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
UNPACK = {".zst": "zstd -d", ".zstd": "zstd -d", ".gz": "gunzip", ".bz2": "bunzip2", ".xz": "unxz"}
"""Commands that unpack files compressed as a whole, by their suffix."""
METADATA = "metadata.yaml"
BAG_INFORMATION = "rosbag2_bagfile_information"
_PART = re.compile(rf"(.*)_\d+\.(?:mcap|db3)(?:{'|'.join(map(re.escape, UNPACK))})?")
"""Name of a file in a folder of rosbag2: the bag's and the part's number."""
MAX_CHUNK = 64 * 2**20
"""Bytes of a chunk, or of a message compressed by itself, when unpacked: room for images."""
_FAULTS = (*DAMAGE, AnyReaderError, sqlite3.Error, AssertionError, TypeError, EOFError)
"""What the libraries raise on a file that is cut, altered or no bag."""


@dataclass(frozen=True)
class Topic:
    """One topic of a bag: its type, such as `sensor_msgs/msg/Imu`, and number of messages.

    Without a definition of its type its messages cannot be read.
    """

    type: str
    count: int
    defined: bool = True


@dataclass(frozen=True)
class BagMessage:
    """One message: its topic, when it was received [ns], and its decoded content."""

    topic: str
    received_ns: int
    content: Any


class Bag:
    """A bag, open within a `with` statement.

    Attributes:
        path: a `.bag`, `.mcap` or `.db3` file, or a folder of rosbag2.
        topics: by name.
        start_ns: when its first message was received.
        length_s: from then to the last message.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self.topics: Mapping[str, Topic] = {}
        self.start_ns, self.length_s = 0, 0.0
        self._connections: list[Connection] = []
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        """Open it.

        Raises:
            FileMissingError, FileUnreadableError: no such file, or no bag by its name.
            RecordingError: damaged, or with definitions that contradict each other.
        """
        if not self.path.exists():
            raise FileMissingError(self.path, "does not exist; name a bag")
        folder = self.path.is_dir()
        if folder and not (self.path / METADATA).is_file():
            raise FileUnreadableError(
                self.path, f"has no {METADATA}; {_without_metadata(self.path)}"
            )
        with self._damage(), ExitStack() as stack:
            copies = Path(stack.enter_context(TemporaryDirectory()))
            if folder:
                information = _checked_metadata(self.path)
                path, files = self.path, sorted(self.path.glob("*.mcap"))
            else:
                path = self._unpacked(stack)
                files = [path]
            for file in files:
                if file.suffix == ".mcap":
                    _check_sums(file, file if folder else self.path)
            check_logs(path, self.path)
            if unmerged(path):
                path = merged(path, METADATA, copies)
            if folder:
                _check_count(path, information.get("message_count"), self.path)
            elif path.suffix == ".mcap":
                path = of_this_profile(path, self.path, copies)
            reader = AnyReader([path], default_typestore=typestore())
            self._reader = stack.enter_context(reader)
            self._connections = list(reader.connections)
            defined = {None, *reader.typestore.fielddefs}
            self.topics = {
                name: Topic(info.msgtype or "several types", info.msgcount, info.msgtype in defined)
                for name, info in reader.topics.items()
            }
            self.start_ns = reader.start_time
            self.length_s = 1e-9 * (reader.end_time - reader.start_time)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def messages(
        self, topics: Collection[str], from_s: float | None = None, to_s: float | None = None
    ) -> Iterator[BagMessage]:
        """Messages of some topics in the order received, of a span since the bag's start [s].

        Raises:
            RecordingError: where a message cannot be decoded.
        """
        wanted = [one for one in self._connections if one.topic in topics]
        if not wanted:
            return
        for one in wanted:
            if one.msgtype not in self._reader.typestore.fielddefs:
                raise RecordingError(
                    self.path,
                    f"{one.topic} is of {one.msgtype}, which the bag does not define; convert it "
                    "where that type is installed: `ros2 bag convert` to mcap",
                )
        ends = (None if at is None else self.start_ns + round(1e9 * at) for at in (from_s, to_s))
        with self._damage():
            for one, received, data in self._reader.messages(wanted, *ends):
                if data.startswith(ZSTD):  # of a bag that compresses message by message
                    _require_small(self.path, zstandard.frame_content_size(data), "message")
                    # The bound holds where the frame does not say its size.
                    data = zstandard.decompress(data, MAX_CHUNK)  # noqa: PLW2901
                content = self._reader.deserialize(data, one.msgtype)
                yield BagMessage(one.topic, received, content)

    def _unpacked(self, stack: ExitStack) -> Path:
        """The file, or what zstd packed in it, which is there until `stack` is closed.

        Raises:
            FileUnreadableError: no bag by its name.
        """
        packed = self.path.suffix in UNPACK
        name = self.path.with_suffix("") if packed else self.path
        if name.suffix not in BAG_SUFFIXES:
            problem = f"is no bag by its name ({', '.join(BAG_SUFFIXES)}); rename it"
            raise FileUnreadableError(self.path, problem)
        with open_file(self.path) as file:
            by_zstd = file.read(len(ZSTD)) == ZSTD
        if packed and not by_zstd:
            damaged = "is not compressed by zstd, as its name says; copy it again"
            other = f"is compressed; {_cure(self.path)}"
            zstd = UNPACK[self.path.suffix] == UNPACK[".zst"]
            raise FileUnreadableError(self.path, damaged if zstd else other)
        if not by_zstd:
            return self.path
        unpacked = Path(stack.enter_context(TemporaryDirectory())) / name.name
        with open_file(self.path) as source, unpacked.open("wb") as target:
            zstandard.ZstdDecompressor().copy_stream(source, target)
        return unpacked

    @contextmanager
    def _damage(self) -> Iterator[None]:
        try:
            yield
        except (FileError, GeneratorExit):
            raise
        except (*_FAULTS, OSError) as error:
            if isinstance(error, OSError) and error.errno is not None:
                raise read_error(self.path, error) from error
            raise _damaged(self.path, error) from error


def _checked_metadata(folder: Path) -> Mapping[str, Any]:
    """What the metadata of a folder of rosbag2 says, where all files that it lists are there.

    Raises:
        FileSyntaxError: its metadata lists none.
        FileMissingError: a file is not there.
        FileUnreadableError: it was compressed after it had been recorded.
    """
    metadata = folder / METADATA
    try:
        information: Mapping[str, Any] = yaml.safe_load(read_bytes(metadata))[BAG_INFORMATION]
        files = [folder / PurePath(name).name for name in information["relative_file_paths"]]
    except (yaml.YAMLError, UnicodeDecodeError, TypeError, KeyError, IndexError) as error:
        cure = f"make it again with `ros2 bag reindex {folder}`"
        raise FileSyntaxError(metadata, f"does not list the files of a bag; {cure}") from error
    with named_together(files):
        for file in files:
            _require_file(file, files)
    return information


def _without_metadata(folder: Path) -> str:
    """The cure of a folder of rosbag2 without its metadata, which a killed recorder leaves.

    Parts of one bag, numbered `NAME_0`, `NAME_1`, are no runs of their own.
    """
    parts: dict[str, list[str]] = {}
    for name in sorted(path.name for path in folder.iterdir()):
        if part := _PART.fullmatch(name):
            parts.setdefault(part[1], []).append(name)
    for names in parts.values():
        if len(names) > 1:
            return (
                f"{names[0]} to {names[-1]} in it are {len(names)} parts of one bag: make it again "
                f"with `ros2 bag reindex {folder}`"
            )
    return "name the .mcap or .db3 file in it, or call `ros2 bag reindex`"


def _require_file(file: Path, listed: Collection[Path]) -> None:
    """Refuse a file that the metadata lists and that is not there, or not as it was recorded."""
    if file.exists():
        return
    for suffix in UNPACK:
        packed = file.with_name(f"{file.name}{suffix}")
        if packed.exists():
            problem = f"is compressed, but not listed so in {METADATA}; {_cure(packed)}"
            raise FileUnreadableError(packed, problem)
    others = sorted(set(file.parent.glob(f"*{file.suffix}")) - set(listed))
    cure = f"give {others[0].name} its name again" if len(others) == 1 else "put it back"
    raise FileMissingError(file, f"is listed in {METADATA}, but does not exist; {cure}")


def _check_count(folder: Path, said: object, named: Path) -> None:
    """Refuse SQLite files that hold fewer messages than their metadata says.

    Args:
        folder: of rosbag2. said: its count of messages. named: what an error calls it.

    Raises:
        RecordingError: with the cure.
    """
    there = stored(folder)
    if there is not None and isinstance(said, int) and there < said:
        raise RecordingError(
            named,
            f"{METADATA} says {said} messages, its .db3 files hold {there or 'none'}: copy the "
            ".db3-wal files that lie next to them on the recorder, too (again, where they lie here "
            "already: they were cut in copying), or make do with what is there by "
            f"`ros2 bag reindex {named}`",
        )


def _cure(file: Path) -> str:
    return f"unpack it: `{UNPACK[file.suffix]} {file.name}`"


def _damaged(path: Path, error: BaseException) -> RecordingError:
    reason = reason_of(error).replace("; please report issue.", "")
    if path.is_file() and not path.stat().st_size:
        return RecordingError(path, "is empty; copy it again, or record it again")
    if "invalid magic" in reason:
        return RecordingError(path, "is no MCAP file, though its name says so; name the recording")
    cure = "repair it with `ros2 bag reindex`, `mcap recover` or `rosbag reindex`"
    if "not supported" in reason:
        cure = "convert it with `ros2 bag convert` or `rosbag decompress`"
    return RecordingError(path, f"cannot be read as a bag ({reason}); {cure}")


def _require_small(path: Path, size: int, what: str) -> None:
    """Refuse what would fill the memory, before it is unpacked to so many bytes.

    Raises:
        FileTooLargeError: with the cure.
    """
    if size > MAX_CHUNK:
        problem = f"holds a {what} of {size >> 20} MiB, more than {MAX_CHUNK >> 20}"
        cure = "write it again with smaller ones, for example by `ros2 bag convert`"
        raise FileTooLargeError(path, f"{problem}; {cure}")


def _check_sums(path: Path, named: Path) -> None:
    """Check every chunk of an MCAP file: `rosbags` decodes altered bytes without an error.

    Args:
        path: of the file.
        named: what an error calls it.

    Raises:
        RecordingError: for bytes that were altered.
        FileTooLargeError: for a chunk that would fill the memory.
    """
    try:
        with open_file(path) as file:
            for record in StreamReader(file, emit_chunks=True).records:
                if isinstance(record, Chunk):
                    _require_small(named, record.uncompressed_size, "chunk")
                    check_honest(record)
                    get_chunk_data_stream(record, validate_crc=True)
    except _FAULTS as error:
        raise _damaged(named, error) from error
