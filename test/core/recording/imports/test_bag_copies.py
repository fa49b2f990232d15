"""Bags with SQLite's log next to them, with less than they say, and of other profiles."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from core.recording import bags
from shoecal_core.errors import FileError
from shoecal_core.recording.imports.bag import Bag

JOINTS = ("one", "two")


def killed(folder: Path) -> Path:
    """A bag of SQLite whose messages are in the log, as a recorder that was killed leaves it."""
    path = bags.walk(folder, "walk", "sqlite3", JOINTS).close()
    (file,) = path.glob("*.db3")
    rows = messages(file)
    database = sqlite3.connect(file)
    database.execute("DELETE FROM messages")
    database.commit()
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA wal_autocheckpoint=0")
    database.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rows)
    database.commit()
    # Copied while it is open: closing would put the log into the file.
    copy = folder / "killed"
    shutil.copytree(path, copy)
    database.close()
    return copy


def messages(file: Path) -> list[tuple[object, ...]]:
    database = sqlite3.connect(file)
    found = database.execute("SELECT * FROM messages").fetchall()
    database.close()
    return found


def everything(path: Path) -> list[tuple[str, int]]:
    with Bag(path) as bag:
        return [(one.topic, one.received_ns) for one in bag.messages(bag.topics)]


def test_a_log_whose_file_was_renamed_is_refused(tmp_path: Path) -> None:
    (file,) = killed(tmp_path).glob("*.db3")
    renamed = file.rename(file.with_name("walk_five.db3"))
    with pytest.raises(FileError, match=rf"{file.name}-wal lies next to walk_five.db3.*same name"):
        everything(renamed)


@pytest.mark.parametrize("named", ["folder", "file"])
def test_what_a_killed_recorder_left_in_its_log_is_read(tmp_path: Path, named: str) -> None:
    copy = killed(tmp_path)
    (file,) = copy.glob("*.db3")
    assert messages_without_log(file) == 0
    before = {one.name: one.read_bytes() for one in copy.iterdir()}
    assert everything(copy if named == "folder" else file) == everything(tmp_path / "whole")
    # Nothing of the recording was changed.
    assert {one.name: one.read_bytes() for one in copy.iterdir()} == before


def test_a_file_without_its_log_says_what_is_missing(tmp_path: Path) -> None:
    (file,) = killed(tmp_path).glob("*.db3")
    alone = Path(shutil.copy(file, tmp_path / "alone.db3"))
    with pytest.raises(FileError, match=r"alone.db3: holds no message, and no alone.db3-wal lies"):
        everything(alone)


def messages_without_log(file: Path) -> int:
    database = sqlite3.connect(f"file:{file}?mode=ro&immutable=1", uri=True)
    (count,) = database.execute("SELECT count(*) FROM messages").fetchone()
    database.close()
    return int(count)


@pytest.fixture(autouse=True)
def whole(tmp_path: Path) -> None:
    """The same bag, closed as it should be."""
    (tmp_path / "apart").mkdir()
    bags.walk(tmp_path / "apart", "walk", "sqlite3", JOINTS).close().rename(tmp_path / "whole")


def test_a_bag_without_its_log_says_what_is_missing(tmp_path: Path) -> None:
    copy = killed(tmp_path)
    for log in copy.glob("*.db3-*"):
        log.unlink()
    with pytest.raises(FileError, match=r"says \d+ messages, its .db3 files hold none: copy the"):
        everything(copy)


def test_messages_of_ros_2_are_read_whatever_the_profile(tmp_path: Path) -> None:
    (file,) = bags.walk(tmp_path, "bag", "mcap", JOINTS).close().glob("*.mcap")
    assert everything(
        bags.rewritten(file, tmp_path / "a.mcap", profile="", encoding="cdr")
    ) == everything(file)


def test_messages_of_ros_1_in_mcap_are_read(tmp_path: Path) -> None:
    """As `mcap convert` makes them: the schemas are those of a .bag, and so are the bytes."""
    bag = bags.walk(tmp_path, "old", "ros1", JOINTS).close()
    target = tmp_path / "new.mcap"
    with Bag(bag) as source, target.open("wb") as written:
        writer = Writer(written)
        writer.start(profile="ros1")
        for connection in source._connections:
            name = connection.msgtype.replace("/msg/", "/")
            kind = writer.register_schema(name, "ros1msg", connection.msgdef.data.encode())
            channel = writer.register_channel(connection.topic, "ros1", kind)
            for _, time, data in source._reader.messages([connection]):
                writer.add_message(channel, time, data, time)
        writer.finish()
    with Bag(bag) as one, Bag(target) as other:
        pairs = zip(one.messages(["/joint_states"]), other.messages(["/joint_states"]), strict=True)
        for before, after in pairs:
            assert before.received_ns == after.received_ns
            np.testing.assert_array_equal(before.content.position, after.content.position)


@pytest.mark.parametrize("encoding", ["json", "protobuf"])
def test_messages_of_others_are_named(tmp_path: Path, encoding: str) -> None:
    (file,) = bags.walk(tmp_path, "bag", "mcap", JOINTS).close().glob("*.mcap")
    other = bags.rewritten(file, tmp_path / "a.mcap", profile="", encoding=encoding)
    with pytest.raises(FileError, match=f"its messages are {encoding}, not those of ROS"):
        everything(other)
