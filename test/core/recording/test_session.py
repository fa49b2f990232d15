from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from core.recording import samples
from core.robot import robots
from shoecal_core.errors import (
    FieldError,
    FileError,
    FileMissingError,
    FileTakenError,
    FileUnwritableError,
    NameNotFoundError,
    ShoecalError,
    VersionError,
)
from shoecal_core.files import sha256
from shoecal_core.recording.errors import HashMismatchError, RecordingError, SessionError
from shoecal_core.recording.recover import recover, recovered_path
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot_file import load_robot, shoe_file_of

COUNT = 20


@pytest.fixture
def session(tmp_path: Path, sources: samples.Sources) -> Session:
    return Session.create(tmp_path / "session", *sources, seed=7)


def record(session: Session, motion: str = "landmarks", hint: str = "") -> Path:
    with session.new_run(motion, samples.SUPPORT, hint=hint) as writer:
        samples.write_sample(writer, samples.make_sample(COUNT), session.shoe.names)
    return writer.path


def test_its_robot_is_read_with_its_own_urdf(tmp_path: Path) -> None:
    nao = robots.load("nao", shod=False)
    assert nao.urdf.name != "robot.urdf"
    session = Session.create(tmp_path / "copied", nao.path, nao.urdf, shoe_file_of(nao.path))
    assert load_robot(session.robot_yaml).urdf == session.robot_urdf


def test_create_copies_and_records(session: Session, sources: samples.Sources) -> None:
    path = record(session, hint="train")
    assert path == session.folder / "run_001.mcap"
    again = Session.open(session.folder)
    assert (again.robot, again.shoe_name, again.seed) == ("nao", "test_shoe", 7)
    assert again.robot_yaml.read_bytes() == sources.robot_yaml.read_bytes()
    assert again.robot_urdf.read_bytes() == sources.robot_urdf.read_bytes()
    (entry,) = again.runs
    assert (entry.run, entry.path, entry.hint) == (1, path, "train")
    assert entry.info == replace(
        samples.INFO,
        robot_hash=sha256(sources.robot_yaml),
        shoe_hash=sha256(sources.shoe_yaml),
        urdf_hash=sha256(sources.robot_urdf),
    )
    run = again.read(1)
    np.testing.assert_array_equal(run.readings.value, samples.make_sample(COUNT).volts)
    listed = yaml.safe_load((session.folder / "session.yaml").read_text())
    assert listed == {
        "format": 1,
        "robot": "nao",
        "shoe": "test_shoe",
        "seed": 7,
        "runs": [
            {
                "file": "run_001.mcap",
                "motion": "landmarks",
                "support": [0.02, -0.1, 0.3],
                "set": "train",
            }
        ],
    }
    assert sorted(path.name for path in session.folder.iterdir()) == [
        "robot.urdf",
        "robot.yaml",
        "run_001.mcap",
        "session.yaml",
        "shoe.yaml",
    ]


def test_numbers_of_numpy_are_numbers(session: Session) -> None:
    support = DoubleSupport(*np.array([0.1, -0.2, 0.3]))
    with session.new_run("landmarks", support):
        pass
    (entry,) = Session.open(session.folder).runs
    assert entry.info.support == DoubleSupport(0.1, -0.2, 0.3)


def test_a_run_without_support(session: Session) -> None:
    with session.new_run("walking", None):
        pass
    (entry,) = Session.open(session.folder).runs
    assert entry.info.support is None


def test_sessions_are_never_overwritten(session: Session, sources: samples.Sources) -> None:
    with pytest.raises(FileTakenError, match="never overwritten"):
        Session.create(session.folder, *sources)
    with pytest.raises(FileTakenError, match="never overwritten"):
        Session.create(session.robot_yaml, *sources)


def test_create_makes_all_or_nothing(tmp_path: Path, sources: samples.Sources) -> None:
    sources.robot_urdf.unlink()
    with pytest.raises(FileMissingError, match="robot_urdf: cannot be read"):
        Session.create(tmp_path / "deep" / "session", *sources)
    sources.robot_urdf.write_text(samples.URDF)
    (tmp_path / "file").touch()
    with pytest.raises(FileUnwritableError, match="cannot be made"):
        Session.create(tmp_path / "file" / "session", *sources)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "sources"]
    Session.create(tmp_path / "deep" / "session", *sources)
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["session"]


def test_open_refuses_what_is_no_session(tmp_path: Path, session: Session) -> None:
    with pytest.raises(SessionError, match=r"is no session \(it has no session.yaml\)"):
        Session.open(tmp_path)
    session.robot_urdf.unlink()
    with pytest.raises(SessionError, match=r"has lost its robot\.urdf; put it back"):
        Session.open(session.folder)
    with pytest.raises(FileMissingError, match="does not exist"):
        Session.open(tmp_path / "none")


@pytest.mark.parametrize(
    ("content", "error", "problem"),
    [
        ({"format": 2}, VersionError, "version 2"),
        ({"extra": 1}, FieldError, "extra: unknown key"),
        ({"runs": [{"file": "a.mcap"}]}, FieldError, "is no name of a run"),
        (
            {"runs": [{"file": "run_001.mcap", "motion": "m", "support": [1], "set": ""}]},
            FieldError,
            r"runs\[0\].support",
        ),
        (
            {"runs": [{"file": "run_001.mcap", "motion": "m", "support": None, "set": "tset"}]},
            FieldError,
            "'tset' is not one of",
        ),
    ],
)
def test_bad_session_files(
    session: Session, content: dict[str, object], error: type[FileError], problem: str
) -> None:
    path = session.folder / "session.yaml"
    whole = {"format": 1, "robot": "nao", "shoe": "s", "runs": []}
    path.write_text(yaml.safe_dump({**whole, **content}))
    with pytest.raises(error, match=problem):
        Session.open(session.folder)


def test_interrupted_run(session: Session) -> None:
    record(session)
    writer = session.new_run("second", None)
    samples.write_sample(writer, samples.make_sample(COUNT), session.shoe.names)
    writer.abandon()
    again = Session.open(session.folder)
    assert [entry.run for entry in again.runs] == [1]
    assert again.unfinished == (writer.part,)
    assert record(again).name == "run_003.mcap"
    recover(writer.part, recovered_path(writer.part))
    assert [entry.run for entry in again.runs] == [1, 2, 3]
    assert not again.unfinished
    assert again.read(2).info.motion == "second"


def test_the_disk_counts_not_the_list(session: Session) -> None:
    record(session)
    listed = (session.folder / "session.yaml").read_text()
    record(session)
    (session.folder / "session.yaml").write_text(listed)  # as if killed before it was written
    (session.folder / "run_001.mcap").unlink()
    again = Session.open(session.folder)
    assert [entry.run for entry in again.runs] == [2]
    assert record(again).name == "run_003.mcap"


def test_a_run_under_anothers_number_is_refused(session: Session) -> None:
    record(session).rename(session.folder / "run_004.mcap")
    with pytest.raises(RecordingError, match=r"run_004.mcap: holds run 1"):
        _ = session.runs


def test_unknown_run(session: Session) -> None:
    record(session)
    with pytest.raises(NameNotFoundError, match=r"no run named '2' \(there are: 1\)"):
        session.read(2)


@pytest.mark.parametrize("file", ["robot.yaml", "shoe.yaml", "robot.urdf"])
def test_changed_files_are_found_out(session: Session, file: str) -> None:
    record(session)
    session.read(1)
    with (session.folder / file).open("a") as handle:
        handle.write("\n")
    with pytest.raises(HashMismatchError, match=f"recorded with another {file}") as caught:
        session.read(1)
    assert caught.value.present == sha256(session.folder / file)
    assert len(Session.open(session.folder, force=True).read(1).readings.time) == COUNT


def test_marks(session: Session) -> None:
    for _ in range(3):
        record(session)
    session.mark(train=[1, 3], test=[2])
    hints = [entry.hint for entry in Session.open(session.folder).runs]
    assert hints == ["train", "test", "train"]
    with pytest.raises(ShoecalError, match="run 1 cannot both train and test"):
        session.mark(train=[1], test=[1])
    with pytest.raises(NameNotFoundError, match="no run named '9'"):
        session.mark(train=[9], test=[])
    with pytest.raises(NameNotFoundError, match="no set named 'trian'"):
        session.new_run("m", None, hint="trian")


def test_truth_stands_apart(session: Session) -> None:
    with session.new_run("landmarks", samples.SUPPORT) as writer:
        samples.write_sample(writer, samples.make_sample(COUNT), session.shoe.names)
        with session.new_truth(writer.info) as truth:
            truth.write(samples.START_NS, [0, 0], np.zeros((2, 2)), [1, 2])
    assert session.truth_path(1) == session.folder / "truth" / "run_001.mcap"
    assert read_truth(session.truth_path(1)).grf.tolist() == [3.0]
    assert [entry.path.parent for entry in session.runs] == [session.folder]


def test_a_run_is_read_once_until_its_file_changes(session: Session) -> None:
    path, other = record(session), record(session, motion="unload_left")
    run = session.read(1)
    assert session.read(1) is run
    # A copy in its place, as an editor or a backup puts it there, is another file.
    changed = path.with_name("changed")
    changed.write_bytes(path.read_bytes())
    changed.replace(path)
    assert session.read(1) is not run
    assert session.read(1).info == run.info
    other.unlink()
    with pytest.raises(NameNotFoundError):
        session.read(2)
