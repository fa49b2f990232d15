"""Bags of ROS 1 and ROS 2, opened by `rosbags`: topics, types and decoded messages."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from mcap.records import Chunk
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from shoecal_core.errors import FileError, FileMissingError, FileUnreadableError
from shoecal_core.files import open_file
from shoecal_core.recording.container import DAMAGE
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.schemas import typestore

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
_FAULTS = (*DAMAGE, AnyReaderError, sqlite3.Error, AssertionError, TypeError, EOFError)
"""What the libraries raise on a file that is cut, altered or no bag."""


@dataclass(frozen=True)
class Topic:
    """One topic of a bag: its type, such as `sensor_msgs/msg/Imu`, and number of messages."""

    type: str
    count: int


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
        start_ns, end_ns: when the first and the last message were received.
    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self.topics: Mapping[str, Topic] = {}
        self.start_ns = self.end_ns = 0
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
        if folder and not (self.path / "metadata.yaml").is_file():
            problem = "has no metadata.yaml; name the .mcap or .db3 file in it"
            raise FileUnreadableError(self.path, f"{problem}, or call `ros2 bag reindex`")
        if not folder and self.path.suffix not in BAG_SUFFIXES:
            problem = f"is no bag by its name ({', '.join(BAG_SUFFIXES)}); rename it"
            raise FileUnreadableError(self.path, problem)
        for file in sorted(self.path.glob("*.mcap")) if folder else [self.path]:
            if file.suffix == ".mcap":
                _check_sums(file)
        with self._damage():
            reader = AnyReader([self.path], default_typestore=typestore())
            self._reader = self._stack.enter_context(reader)
            self._connections = list(reader.connections)
            self.topics = {
                name: Topic(info.msgtype or "several types", info.msgcount)
                for name, info in reader.topics.items()
            }
            self.start_ns, self.end_ns = reader.start_time, reader.end_time
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def messages(
        self, topics: Collection[str], from_ns: int | None = None, to_ns: int | None = None
    ) -> Iterator[BagMessage]:
        """Messages of some topics in the order received, of a span of that time [ns].

        Raises:
            RecordingError: where a message cannot be decoded.
        """
        wanted = [one for one in self._connections if one.topic in topics]
        if not wanted:
            return
        with self._damage():
            for one, received, data in self._reader.messages(wanted, from_ns, to_ns):
                content = self._reader.deserialize(data, one.msgtype)
                yield BagMessage(one.topic, received, content)

    @contextmanager
    def _damage(self) -> Iterator[None]:
        try:
            yield
        except (FileError, GeneratorExit):
            raise
        except (*_FAULTS, OSError) as error:
            raise _damaged(self.path, error) from error


def _damaged(path: Path, error: BaseException) -> RecordingError:
    reason = str(error) or type(error).__name__
    cure = "repair it with `ros2 bag reindex`, `mcap recover` or `rosbag reindex`"
    return RecordingError(path, f"cannot be read as a bag ({reason}); {cure}")


def _check_sums(path: Path) -> None:
    """Check every chunk of an MCAP file: `rosbags` decodes altered bytes without an error."""
    try:
        with open_file(path) as file:
            for record in StreamReader(file, emit_chunks=True).records:
                if isinstance(record, Chunk):
                    get_chunk_data_stream(record, validate_crc=True)
    except _FAULTS as error:
        raise _damaged(path, error) from error
