"""Every kind of trouble with a file has a code of its own, whatever the file is for."""

from __future__ import annotations

import errno
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from core.limits import file_size_limit, ordinary_user
from core.recording import samples
from shoecal_core.error_sources.effects.known import effects_from
from shoecal_core.errors import ShoecalError, error_code
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import (
    MAX_YAML_BYTES,
    atomic_write,
    make_folder,
    read_error,
    read_yaml,
    sha256,
    system_error,
)
from shoecal_core.recording.container import read_info
from shoecal_core.recording.imports.csv_table import CsvTable, Layout
from shoecal_core.recording.session import Session
from shoecal_core.recording.writer import RunWriter
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import read_urdf
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import config_dir

SOURCES = Path(__file__).parents[2]
URDF = config_dir() / "robots/nao.urdf"
CALIBRATION = """\
format: 1
id: a
source: set
made_ns: 0
robot: nao
shoe: s
robot_hash: r
shoe_hash: s
weight_n: 50.0
time_offset_s: 0.0
reasons: []
channels:
- {name: left/front, gain: 1.0, offset_n: 0.0}
corrections: []
verdict: PASS
"""

Read = Callable[[Path], object]
READERS: dict[str, Read] = {
    "yaml": read_yaml,
    "hash": sha256,
    "robot": load_robot,
    "shoe": load_shoe,
    "urdf": read_urdf,
    "calibration": load_calibration,
    "run": read_info,
    "csv": lambda path: CsvTable(path, Layout()),
    "effects": effects_from,
}


def code_of(call: Callable[[], object]) -> str:
    """The code of a refusal, of one line."""
    with pytest.raises(ShoecalError) as caught:
        call()
    assert len(str(caught.value).splitlines()) == 1
    return error_code(type(caught.value))


@pytest.fixture(params=READERS)
def read(request: pytest.FixtureRequest) -> Read:
    return READERS[request.param]


# ---- what the system says of a file -------------------------------------------------------------


def test_a_file_that_is_not_there(tmp_path: Path, read: Read) -> None:
    assert code_of(lambda: read(tmp_path / "none.py")) == "file-missing"


def test_a_folder_where_a_file_should_be(tmp_path: Path, read: Read) -> None:
    (tmp_path / "folder.py").mkdir()
    assert code_of(lambda: read(tmp_path / "folder.py")) == "file-unreadable"


def test_a_file_without_rights(read: Read, open_folder: Path) -> None:
    path = open_folder / "secret.py"
    path.touch(mode=0o000)
    with ordinary_user():
        assert code_of(lambda: read(path)) == "file-unreadable"


def test_a_pipe_and_a_name_that_is_none(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert code_of(lambda: read_yaml(tmp_path / "pipe")) == "file-unreadable"
    assert code_of(lambda: read_yaml(tmp_path / "a\0b")) == "file-unreadable"


def test_a_file_that_is_too_large(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    path.write_bytes(b" " * (MAX_YAML_BYTES + 1))
    assert code_of(lambda: read_yaml(path)) == "file-too-large"


@pytest.mark.parametrize(
    ("number", "written", "wanted"),
    [
        (errno.ENOENT, "file-missing", "file-missing"),
        (errno.EEXIST, "file-taken", "file-taken"),
        (errno.ENOSPC, "disk-full", "disk-full"),
        (errno.EDQUOT, "disk-full", "disk-full"),
        (errno.EFBIG, "disk-full", "disk-full"),
        (errno.EACCES, "file-unwritable", "file-unreadable"),
        (errno.EPERM, "file-unwritable", "file-unreadable"),
        (errno.EROFS, "file-unwritable", "file-unreadable"),
        (errno.EIO, "file-unwritable", "file-unreadable"),
        (errno.EISDIR, "file-unwritable", "file-unreadable"),
        (errno.ENAMETOOLONG, "file-unwritable", "file-unreadable"),
    ],
)
def test_what_the_system_says(number: int, written: str, wanted: str) -> None:
    refusal = OSError(number, os.strerror(number))
    error = system_error("x", refusal, "cannot be written", "mend it")
    assert error_code(type(error)) == written
    assert str(error) == f"x: cannot be written ({os.strerror(number)}); mend it"
    assert error_code(type(read_error("x", refusal))) == wanted
    assert str(read_error("x", refusal)) == f"x: cannot be read ({os.strerror(number)})"


# ---- what is to be written ----------------------------------------------------------------------

Write = Callable[[Path], object]
WRITERS: dict[str, Write] = {
    "file": lambda folder: atomic_write(folder / "x", "new"),
    "run": lambda folder: RunWriter(folder / "run_001.mcap", samples.INFO),
    "session": lambda folder: Session.create(
        folder / "session", URDF.with_suffix(".yaml"), URDF, config_dir() / "shoes/nao_shoe.yaml"
    ),
}


@pytest.fixture(params=WRITERS)
def write(request: pytest.FixtureRequest) -> Write:
    return WRITERS[request.param]


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that anybody may look into: those of pytest are the user's alone."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)
        Path(name).chmod(0o755)


def test_a_full_disk(tmp_path: Path, write: Write) -> None:
    with file_size_limit(0):
        assert code_of(lambda: write(tmp_path)) == "disk-full"


def test_a_read_only_folder(open_folder: Path, write: Write) -> None:
    open_folder.chmod(0o555)
    with ordinary_user():
        assert code_of(lambda: write(open_folder)) == "file-unwritable"
    assert list(open_folder.iterdir()) == []


def test_what_is_there_already(tmp_path: Path) -> None:
    folder = tmp_path / "session"
    folder.mkdir()
    (folder / "x").touch()
    (tmp_path / "run_001.mcap").touch()
    assert code_of(lambda: WRITERS["session"](tmp_path)) == "file-taken"
    assert code_of(lambda: WRITERS["run"](tmp_path)) == "file-taken"
    assert code_of(lambda: make_folder(folder / "x")) == "file-taken"


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    for name in ("file", "run"):
        assert code_of(partial(WRITERS[name], tmp_path / "none")) == "file-missing"


# ---- what stands in a file ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "name", "text", "code"),
    [
        ("yaml", "x.yaml", "a: [", "file-syntax"),
        ("yaml", "x.yaml", "- a", "file-syntax"),
        ("robot", "x.yaml", "a: b: c", "file-syntax"),
        ("robot", "x.yaml", "format: 1", "field"),
        ("robot", "x.yaml", "format: 99", "version"),
        ("shoe", "x.yaml", "format: 1\nname: 3", "field"),
        ("urdf", "x.urdf", "<robot", "file-syntax"),
        ("urdf", "x.urdf", "<a/>", "urdf"),
        ("urdf", "x.urdf", '<!DOCTYPE robot [<!ENTITY a "b">]><robot name="a"/>', "urdf"),
        ("urdf", "x.urdf", '<robot name="a"/>', "urdf"),
        ("urdf", "x.urdf", '<robot name="a"><link name="b"/></robot>', "urdf"),
        ("calibration", "x.yaml", "a: &b [*b]", "file-syntax"),
        ("calibration", "x.yaml", CALIBRATION.replace("robot: nao\n", ""), "field"),
        ("calibration", "x.yaml", CALIBRATION.replace("gain: 1.0", "gain: .nan"), "field"),
        ("calibration", "x.yaml", CALIBRATION.replace("gain: 1", "gain: 0"), "calibration-file"),
        ("csv", "x.csv", "a,b", "file-syntax"),
        ("csv", "x.csv", "a,b\n1", "file-syntax"),
        ("effects", "x.py", "def (:", "file-syntax"),
        ("effects", "x.py", "", "field"),
        ("run", "x.mcap", "no recording", "recording"),
    ],
)
def test_what_is_wrong_in_a_file(
    tmp_path: Path, kind: str, name: str, text: str, code: str
) -> None:
    (tmp_path / name).write_text(text)
    assert code_of(lambda: READERS[kind](tmp_path / name)) == code


def test_the_calibration_that_is_altered_here_is_whole(tmp_path: Path) -> None:
    (tmp_path / "x.yaml").write_text(CALIBRATION)
    assert load_calibration(tmp_path / "x.yaml").verdict == "PASS"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<mass value="', '<mass value="-'),
        ('type="revolute"', 'type="planar"'),
        ('lower="', 'lower="9'),
        ("<axis xyz=", '<axis xyz="0 0 0" lost='),
    ],
)
def test_every_fault_of_a_urdf(tmp_path: Path, old: str, new: str) -> None:
    text = URDF.read_text()
    assert old in text
    (tmp_path / "nao.urdf").write_text(text.replace(old, new))
    assert code_of(lambda: read_urdf(tmp_path / "nao.urdf")) == "urdf"


def test_what_is_wrong_with_a_session(tmp_path: Path) -> None:
    WRITERS["session"](tmp_path)
    folder = tmp_path / "session"
    assert code_of(lambda: Session.open(tmp_path / "none")) == "file-missing"
    assert code_of(lambda: Session.open(tmp_path)) == "session"
    (folder / "robot.yaml").rename(folder / "elsewhere.yaml")
    assert code_of(lambda: Session.open(folder)) == "session"
    (folder / "elsewhere.yaml").rename(folder / "robot.yaml")
    (folder / "session.yaml").write_text("format: 1\nrobot: nao\nshoe: nao_shoe\nruns: 1\n")
    assert code_of(lambda: Session.open(folder)) == "field"


# ---- codes of all errors of files ---------------------------------------------------------------


PACKAGES = [SOURCES / package / package for package in ("shoecal_core", "shoecal_ros")]
TEXTS = {path: path.read_text() for package in PACKAGES for path in sorted(package.rglob("*.py"))}
BASES = dict(
    found
    for text in TEXTS.values()
    for found in re.findall(r"^class (\w+Error)\((\w+Error)\):", text, re.MULTILINE)
)
"""By name, the error that another one is a kind of."""


def kinds() -> list[str]:
    """Names of all errors of files."""

    def of_files(name: str) -> bool:
        base = BASES.get(name)
        return base is not None and (base == "FileError" or of_files(base))

    return [name for name in BASES if of_files(name)]


def test_none_is_told_by_the_code_of_all() -> None:
    told = re.compile(r"(?:raise|return|else|=) FileError\(")
    raised = [path.name for path, text in TEXTS.items() if told.search(text)]
    assert raised == [], "name what is wrong by a kind of FileError"


def test_the_page_on_codes_names_them_all() -> None:
    page = (SOURCES / "docs/reference/diagnostics.md").read_text()
    table = page.split("What is wrong with a file", 1)[1]
    listed = [
        code
        for row in re.findall(r"^\|([^|]*)\|", table, re.MULTILINE)
        for code in re.findall("`(.*?)`", row)
    ]
    assert sorted(listed) == sorted(error_code(type(kind, (ShoecalError,), {})) for kind in kinds())
