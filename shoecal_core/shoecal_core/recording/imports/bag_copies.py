"""Bags that `rosbags` reads as a copy only: with a log next to them, or of another profile."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Message, Schema
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from shoecal_core.files import open_file
from shoecal_core.recording.errors import RecordingError

LOG = "-wal"
"""Suffix of SQLite's write-ahead log: what a recorder that was killed had not yet put in the file
next to it."""
ROS2, CDR, ROS1 = "ros2", "cdr", "ros1"
_Message = tuple[Schema, Channel, Message]


def unmerged(path: Path) -> bool:
    """Whether a bag, a file or a folder, has messages in logs next to its files."""
    return any(_log(file).is_file() and _log(file).stat().st_size for file in _files(path))


def check_logs(path: Path, named: Path) -> None:
    """Refuse a bag next to which a log lies that no file there owns, or whose own log is not there.

    What a log holds would be lost.

    Args:
        path: of the bag, a file or a folder.
        named: what an error calls it.

    Raises:
        RecordingError: with the cure.
    """
    files = _files(path)
    if not files:
        return
    for log in sorted(files[0].parent.glob(f"*.db3{LOG}")):
        if log.stat().st_size and not log.with_name(log.name.removesuffix(LOG)).is_file():
            raise RecordingError(
                named,
                f"{log.name} lies next to {files[0].name}, and the file that it belongs to does "
                "not: it holds what a recorder wrote last; give both the same name again (the log "
                f"with {LOG} at its end), or move it away if it is another recording's",
            )
    # Of a folder the metadata says how many messages there are.
    if path.is_file() and _keeps_log(path) and not _log(path).is_file() and not stored(path):
        raise RecordingError(
            named,
            f"holds no message, and no {path.name}{LOG} lies next to it: copy that from the "
            "recorder, too, where one that was killed left all that it wrote; else record it again",
        )


def merged(path: Path, metadata: str, folder: Path) -> Path:
    """A copy of a bag with its logs merged into it.

    Args:
        path: of the bag, a file or a folder.
        metadata: name of the file that a folder has besides.
        folder: where the copy goes.
    """
    for file in _files(path):
        copy = folder / file.name
        shutil.copy(file, copy)
        if _log(file).is_file():
            shutil.copy(_log(file), _log(copy))
        with closing(sqlite3.connect(copy)) as database:
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            database.execute("PRAGMA journal_mode=DELETE")
    if path.is_dir():
        shutil.copy(path / metadata, folder / metadata)
        return folder
    return folder / path.name


def stored(path: Path) -> int | None:
    """Messages in the SQLite files of a bag, a file or a folder; None where it has no such file."""
    files = _files(path)
    if not files:
        return None
    count = 0
    for file in files:
        with closing(sqlite3.connect(f"file:{file}?mode=ro&immutable=1", uri=True)) as database:
            count += int(database.execute("SELECT count(*) FROM messages").fetchone()[0])
    return count


def of_this_profile(path: Path, named: Path, folder: Path) -> Path:
    """An MCAP file that `rosbags` reads: itself, or a copy with the same messages.

    Args:
        path: of the file.
        named: what an error calls it.
        folder: where a copy goes.

    Raises:
        RecordingError: for messages that are not of ROS.
    """
    with open_file(path) as file:
        reader = make_reader(file)
        profile, summary = reader.get_header().profile, reader.get_summary()
        channels = {} if summary is None else summary.channels
        encodings = {one.message_encoding for one in channels.values()}
        if summary is None or (profile == ROS2 and encodings <= {CDR}):
            return path
        # Channels of other encodings are nothing that is imported.
        if CDR in encodings:
            return _as_ros2(_of(reader, CDR), folder / path.name)
        if ROS1 in encodings:
            return _as_ros1(_of(reader, ROS1), folder / f"{path.stem}.bag")
    held = ", ".join(sorted(encodings))
    raise RecordingError(
        named,
        f"its messages are {held}, not those of ROS (cdr or ros1); export them to CSV and use "
        "`shoecal import csv`",
    )


def _of(reader: McapReader, encoding: str) -> Iterator[_Message]:
    for schema, channel, message in reader.iter_messages():
        if channel.message_encoding == encoding and schema is not None:
            yield schema, channel, message


def _as_ros2(messages: Iterator[_Message], target: Path) -> Path:
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start(profile=ROS2)
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for schema, channel, message in messages:
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id], channel.metadata
                )
            writer.add_message(
                channels[channel.id], message.log_time, message.data, message.publish_time
            )
        writer.finish()
    return target


def _as_ros1(messages: Iterator[_Message], target: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(target) as writer:
        connections = {}
        for schema, channel, message in messages:
            if channel.id not in connections:
                package, _, name = schema.name.rpartition("/")
                kind = f"{package}/msg/{name}"
                store.register(
                    {
                        key: one
                        for key, one in get_types_from_msg(schema.data.decode(), kind).items()
                        if key not in store.fielddefs
                    }
                )
                connections[channel.id] = writer.add_connection(
                    channel.topic, kind, typestore=store
                )
            writer.write(connections[channel.id], message.log_time, message.data)
    return target


def _files(path: Path) -> list[Path]:
    return sorted(path.glob("*.db3")) if path.is_dir() else [path] * (path.suffix == ".db3")


def _keeps_log(file: Path) -> bool:
    """Whether SQLite wrote a file with a log: by its header (SQLite's file format, sec. 1.3.3)."""
    with open_file(file) as source:
        return source.read(19)[18:] == b"\2"


def _log(file: Path) -> Path:
    return file.with_name(f"{file.name}{LOG}")
