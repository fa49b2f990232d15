"""Writing one run: little is lost at a kill, and a file is whole or says that it is not."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from mcap.writer import Writer

from shoecal_core.errors import FileError, FileTakenError, NameNotFoundError, ShoecalError
from shoecal_core.files import system_error
from shoecal_core.recording import schemas
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.info import RECORD, RunInfo

CHUNK_BYTES = 16 * 1024
WHOLE_CHUNK_BYTES = 64 * 1024
"""Of files that are made in one go."""
SYNC_NS = 500_000_000
"""Span of log time after which all that was written is made durable."""
MAX_TIME_NS = 2**63 - 1
"""Largest time of a ROS stamp's kind."""

PART = ".part"
"""Suffix of a file that is not (yet) whole."""


class _Container(Protocol):
    """The part of mcap's writer in use; the library leaves some of it untyped."""

    def start(self, profile: str, library: str) -> None: ...
    def add_metadata(self, name: str, data: dict[str, str]) -> None: ...
    def register_schema(self, name: str, encoding: str, data: bytes) -> int: ...
    def register_channel(
        self, topic: str, message_encoding: str, schema_id: int, metadata: dict[str, str]
    ) -> int: ...
    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int = 0
    ) -> None: ...
    def flush(self) -> None: ...
    def finish(self) -> None: ...


class RunWriter:
    """Writes messages to `part`, which becomes `path` when it is closed whole.

    As a context manager it closes at the end; on an exception what was recorded stays under
    the unfinished name. After the first failure (a full disk) every call raises that failure.

    Attributes:
        path: of the whole file.
        part: of the file while it is written.
        info: written into it.
    """

    def __init__(
        self,
        path: Path,
        info: RunInfo,
        *,
        topics: Mapping[str, str] = schemas.RUN_TOPICS,
        suffix: str = PART,
        live: bool = True,
    ) -> None:
        """Start a file.

        Args:
            path: of the whole file.
            info: what it says of itself.
            topics: types by topic of this kind of file.
            suffix: of the file while it is written.
            live: whether it takes its time, so that little may be lost at a kill; what can be
                made again is written in larger pieces and made durable when it is closed.

        Raises:
            FileTakenError: when it exists already.
            FileUnwritableError, FileMissingError: when it cannot be made.
        """
        self.path = Path(path)
        self.part = self.path.with_name(self.path.name + suffix)
        self.info = info
        self._topics = topics
        self._live = live
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._synced_ns: int | None = None
        self._closed = False
        self._error: FileError | None = None
        if self.path.exists():
            raise FileTakenError(self.path, "exists already; recordings are never overwritten")
        try:
            # Exclusive: an unfinished recording of the same name is never overwritten either.
            self._file = self.part.open("xb")
        except OSError as error:
            cure = "check the folder and its rights"
            raise system_error(self.part, error, "cannot be made", cure) from error
        self._mcap: _Container = Writer(
            self._file,
            chunk_size=CHUNK_BYTES if live else WHOLE_CHUNK_BYTES,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        with self._guard():
            self._mcap.start(profile="ros2", library="shoecal")
            self._mcap.add_metadata(RECORD, info.to_metadata())
            self._sync()

    def write(self, topic: str, data: bytes, log_time_ns: int) -> None:
        """Append one message.

        Args:
            topic: one of the topics of this kind of file.
            data: CDR bytes of the topic's type.
            log_time_ns: when it was received.

        Raises:
            NameNotFoundError: for a topic that is not recorded.
            FileUnwritableError: when it cannot be written; DiskFullError where there is no room.
        """
        if not 0 <= log_time_ns <= MAX_TIME_NS:
            raise ShoecalError(f"{topic}: log time {log_time_ns} ns cannot be recorded")
        with self._guard():
            self._mcap.add_message(
                channel_id=self._channel(topic),
                log_time=log_time_ns,
                data=bytes(data),
                publish_time=log_time_ns,
            )
            if self._synced_ns is None:
                self._synced_ns = log_time_ns
            elif self._live and abs(log_time_ns - self._synced_ns) >= SYNC_NS:
                self._synced_ns = log_time_ns
                self._sync()

    def close(self) -> Path:
        """Finish the file and give it its name, `path`.

        Raises:
            FileUnwritableError: when not all could be written; what there is stays unfinished.
        """
        self._finish()
        with self._guard():
            self.part.rename(self.path)
        self._closed = True
        return self.path

    def abandon(self) -> Path:
        """End an interrupted recording: what was recorded stays, as `part`."""
        self._finish()
        self._closed = True
        return self.part

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._closed:
            return
        if kind is None:
            self.close()
        else:
            with suppress(FileError):  # the exception under way says more
                self.abandon()

    def _channel(self, topic: str) -> int:
        if topic not in self._channels:
            if topic not in self._topics:
                raise NameNotFoundError("recorded topic", topic, tuple(self._topics))
            kind = self._topics[topic]
            if kind not in self._schemas:
                self._schemas[kind] = self._mcap.register_schema(
                    kind, "ros2msg", schemas.schema_text(kind)
                )
            self._channels[topic] = self._mcap.register_channel(
                topic, "cdr", self._schemas[kind], dict(schemas.channel_metadata(kind))
            )
        return self._channels[topic]

    def _sync(self) -> None:
        self._mcap.flush()
        os.fsync(self._file.fileno())

    def _finish(self) -> None:
        with self._guard():
            self._mcap.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    @contextmanager
    def _guard(self) -> Iterator[None]:
        """Turn the first failure into a FileError, and raise it again ever after."""
        if self._error is not None:
            raise self._error
        if self._closed:
            raise RecordingError(self.path, "closed already; nothing more can be recorded to it")
        try:
            yield
        except OSError as error:
            self._error = system_error(
                self.part,
                error,
                "cannot be written",
                "correct that and record again: `shoecal recover` saves what was written before",
            )
            with suppress(OSError):  # what is left in its buffer fails again
                self._file.close()
            raise self._error from error
