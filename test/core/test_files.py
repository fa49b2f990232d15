"""Files that are whole or not at all, and errors that name the place and the cure."""

from __future__ import annotations

import datetime
import errno
import math
import os
import pickle
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.limits import file_size_limit, ordinary_user
from shoecal_core.errors import (
    LONGEST,
    FileError,
    NameNotFoundError,
    ShapeError,
    ShoecalError,
    VersionError,
    one_line,
)
from shoecal_core.files import (
    MAX_YAML_BYTES,
    MAX_YAML_VALUES,
    Fields,
    atomic_write,
    read_bytes,
    read_yaml,
    sha256,
    write_yaml,
)

HUGE = "9" * 400


@pytest.fixture
def fields(tmp_path: Path) -> Callable[[str | bytes], Fields]:
    """Reads a text as a file."""

    def read(text: str | bytes) -> Fields:
        path = tmp_path / "some.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_yaml(path)

    return read


def refused(path: Path, field: str, call: Callable[[], object]) -> str:
    """The problem that a call finds with a field; its message is one short line."""
    with pytest.raises(FileError) as caught:
        call()
    error = caught.value
    assert error.path == path
    assert error.field == field
    message = str(error)
    assert message.startswith(f"{path}: {field}: " if field else f"{path}: ")
    assert len(message.splitlines()) == 1
    assert len(message) < len(str(path)) + 300
    return error.problem


# ---- fields -----------------------------------------------------------------------------------

GOOD = """
text: abc
yes: true
count: 3
number: -2.5e-3
whole: 7
row: [1, 2.5, 3]
table: [[1, 2], [3, 4], [5, 6]]
inner: {deep: {x: 1}}
list: [{x: 1}, {x: 2}]
names: [a, b]
nothing: null
"""


def test_fields_of_every_kind(fields: Callable[[str], Fields]) -> None:
    found = fields(GOOD.replace("yes:", "flag:"))
    assert found.text("text") == "abc"
    assert found.boolean("flag") is True
    assert found.integer("count", minimum=3) == 3
    assert found.number("number", minimum=-2.5e-3, maximum=0.0) == -2.5e-3
    assert found.number("whole") == 7.0
    np.testing.assert_array_equal(found.array("row", (3,)), [1.0, 2.5, 3.0])
    np.testing.assert_array_equal(found.array("table", (None, 2)), [[1, 2], [3, 4], [5, 6]])
    assert found.mapping("inner").mapping("deep").number("x") == 1.0
    assert [item.integer("x") for item in found.items("list")] == [1, 2]
    assert found.texts("names") == ["a", "b"]
    assert found.choice("text", {"abc": 1, "z": 2}) == "abc"
    assert "text" in found
    assert "nothing" not in found
    assert "absent" not in found


def test_defaults_stand_in_for_what_is_absent_or_null(fields: Callable[[str], Fields]) -> None:
    found = fields("nothing: null")
    for key in ("nothing", "absent"):
        assert found.text(key, "x") == "x"
        assert found.integer(key, 4) == 4
        assert math.isnan(found.number(key, math.nan))
        for read in (found.text, found.boolean, found.integer, found.number, found.mapping):
            assert "missing" in refused(found.path, key, partial(read, key))


WRONG: dict[str, tuple[str, str, Callable[[Fields], object], str]] = {
    "text from a number": ("a: 1", "a", lambda f: f.text("a"), "expected text, got 1"),
    "text from a date": ("a: 2026-01-02", "a", lambda f: f.text("a"), "expected text"),
    "boolean from text": ("a: 'true'", "a", lambda f: f.boolean("a"), "true or false"),
    "boolean from 1": ("a: 1", "a", lambda f: f.boolean("a"), "true or false"),
    "integer from a fraction": ("a: 1.0", "a", lambda f: f.integer("a"), "whole number"),
    "integer from true": ("a: true", "a", lambda f: f.integer("a"), "whole number, got True"),
    "integer below its minimum": (
        "a: 1", "a", lambda f: f.integer("a", minimum=2), "at least 2, got 1"
    ),
    "number from text": ("a: x", "a", lambda f: f.number("a"), "expected a number"),
    "number from true": ("a: true", "a", lambda f: f.number("a"), "expected a number"),
    "number in words": ("a: one", "a", lambda f: f.number("a"), "like 1.5e-3"),
    "number from a list": ("a: [1]", "a", lambda f: f.number("a"), "expected a number"),
    "number from a long list": (
        f"a: [{'1, ' * 10000}]", "a", lambda f: f.number("a"), "expected a number"
    ),
    "nan": ("a: .nan", "a", lambda f: f.number("a"), "finite number, got nan"),
    "infinity": ("a: -.inf", "a", lambda f: f.number("a"), "finite number, got -inf"),
    "overflow": ("a: 1.0e+400", "a", lambda f: f.number("a"), "finite number, got inf"),
    "huge number": (f"a: {HUGE}", "a", lambda f: f.number("a"), "too large"),
    "below": ("a: 1", "a", lambda f: f.number("a", minimum=2.0), "at least 2, got 1"),
    "not above": ("a: 2", "a", lambda f: f.number("a", above=2.0), "above 2, got 2"),
    "beyond": (
        "a: 5", "a", lambda f: f.number("a", minimum=1.0, maximum=4.0), "at least 1 and at most 4"
    ),
    "array of text": ("a: [1, x]", "a", lambda f: f.array("a", (2,)), "expected a number"),
    "array with nan": ("a: [1, .nan]", "a", lambda f: f.array("a", (2,)), "finite"),
    "array with true": ("a: [1, true]", "a", lambda f: f.array("a", (2,)), "expected a number"),
    "array with null": ("a: [1, null]", "a", lambda f: f.array("a", (2,)), "expected a number"),
    "array with a huge number": (
        f"a: [1, {HUGE}]", "a", lambda f: f.array("a", (2,)), "too large"
    ),
    "array of another length": (
        "a: [1, 2]", "a", lambda f: f.array("a", (3,)), "3 numbers, got shape (2,)"
    ),
    "array of another rank": ("a: 1", "a", lambda f: f.array("a", (None,)), "n numbers"),
    "array that is deeper": ("a: [[1], [2]]", "a", lambda f: f.array("a", (2,)), "2 numbers"),
    "array with ragged rows": (
        "a: [[1, 2], [3]]", "a", lambda f: f.array("a", (None, 2)), "rows of equal length"
    ),
    "array of mappings": ("a: [{x: 1}]", "a", lambda f: f.array("a", (1,)), "expected a number"),
    "mapping from a list": ("a: [1]", "a", lambda f: f.mapping("a"), "mapping of keys"),
    "list from a mapping": ("a: {x: 1}", "a", lambda f: f.items("a"), "expected a list"),
    "list of numbers": ("a: [{x: 1}, 2]", "a[1]", lambda f: f.items("a"), "mapping of keys"),
    "names from text": ("a: abc", "a", lambda f: f.texts("a"), "list of names"),
    "names with a number": ("a: [b, 1]", "a", lambda f: f.texts("a"), "list of names"),
    "no such choice": (
        "a: red", "a", lambda f: f.choice("a", {"green": 1, "blue": 2}), "one of: green, blue"
    ),
    "unknown key": ("aa: 1", "aa", lambda f: f.only("a", "b"), "unknown key; did you mean 'a'?"),
    "missing": ("b: 1", "a", lambda f: f.number("a"), "is missing; add it"),
    "nested": (
        "a: {b: [{c: 1}, {c: x}]}",
        "a.b[1].c",
        lambda f: f.mapping("a").items("b")[1].number("c"),
        "expected a number",
    ),
    "format that is no number": ("format: one", "format", lambda f: f.format(1), "whole number"),
    "format zero": ("format: 0", "format", lambda f: f.format(1), "must be 1 to 1"),
    "no format": ("a: 1", "format", lambda f: f.format(1), "is missing"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_each_wrong_kind_names_file_and_field(name: str, fields: Callable[[str], Fields]) -> None:
    text, field, call, problem = WRONG[name]
    found = fields(text)
    assert problem in refused(found.path, field, lambda: call(found))


def test_a_newer_format_is_refused_with_the_cure(fields: Callable[[str], Fields]) -> None:
    found = fields("format: 3")
    with pytest.raises(VersionError, match=r"format: version 3 .* known: 2\); update shoecal"):
        found.format(2)
    assert found.format(3) == 3
    assert found.format(4) == 3


# ---- YAML -------------------------------------------------------------------------------------

BOMB = "a: &a [x, x]\n" + "".join(
    f"{new}: &{new} [*{old}, *{old}, *{old}, *{old}, *{old}, *{old}, *{old}, *{old}]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
NOT_YAML: dict[str, tuple[str | bytes, str]] = {
    "a bomb of aliases": (BOMB, "line 2 (aliases are not allowed)"),
    "an alias in a merge": ("a: &a {x: 1}\nb: {<<: *a}", "line 2 (aliases"),
    "a program": ("a: !!python/object/apply:os.mkdir [{target}]", "line 1 (tags are not allowed)"),
    "a tagged word": ("a: !!bool abc", "tags are not allowed"),
    "a tagged nothing": ("a: !!int ''", "tags are not allowed"),
    "a tagged document": ("--- !!timestamp abc", "tags are not allowed"),
    "a local tag": ("a: !mine 1", "tags are not allowed"),
    "a key twice": ("a: 1\nb: {c: 2, d: 3, c: 4}", "line 2 (key 'c' stands twice)"),
    "an octal number": ("a: 010", "'010' is no plain decimal number"),
    "a hexadecimal number": ("a: 0x" + "f" * 6000, "no plain decimal number"),
    "a sexagesimal number": ("a: 1:30", "'1:30' is no plain decimal number"),
    "a sexagesimal fraction": ("a: 190:20:30.15", "no plain decimal number"),
    "an endless number": ("a: " + "9" * 6000, "not valid YAML"),
    "an impossible date": ("a: 2026-99-99", "not valid YAML"),
    "an unhashable key": ("? [1]\n: 2", "unhashable"),
    "broken syntax": ("a: 1\nb: [1, 2\nc: 3", "line 3"),
    "two documents": ("a: 1\n---\nb: 2", "line 2"),
    "a deep nest": ("a: " + "[" * 1500, "not valid YAML"),
    "a control character": ("a: \x00", "not valid YAML"),
    "other bytes": (b"a: \xff\xfe", "not valid YAML"),
    "a list": ("[1, 2]", "mapping of keys to values at the top level"),
    "nothing": ("", "is empty"),
    "too many values": ("a: [" + "1," * MAX_YAML_VALUES + "]", "more than 100000 values"),
    "too much": (b" " * (MAX_YAML_BYTES + 1), "larger than 1 MiB"),
}


@pytest.mark.parametrize("name", NOT_YAML)
def test_what_is_not_plain_yaml_is_refused_as_a_whole(
    name: str, fields: Callable[[str | bytes], Fields], tmp_path: Path
) -> None:
    text, problem = NOT_YAML[name]
    target = tmp_path / "made"
    if isinstance(text, str):
        text = text.replace("{target}", str(target))
    assert problem in refused(tmp_path / "some.yaml", "", lambda: fields(text))
    assert not target.exists()


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    for path, reason in ((tmp_path / "none", "No such file"), (tmp_path, "directory")):
        for read in (read_bytes, read_yaml, sha256):
            assert reason in refused(path, "", partial(read, path))


def test_what_may_have_no_end_is_not_read(tmp_path: Path) -> None:
    pipe, sparse = tmp_path / "pipe", tmp_path / "sparse"
    os.mkfifo(pipe)
    with sparse.open("wb") as file:
        file.truncate(4 * 2**30)
    for path in (pipe, Path("/dev/zero")):
        for read in (read_bytes, read_yaml, sha256):
            assert "pipe or a device" in refused(path, "", partial(read, path))
    for read in (read_bytes, read_yaml):
        assert "larger than" in refused(sparse, "", partial(read, sparse))


SCALARS = st.one_of(
    st.integers(-(2**70), 2**70),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
    st.text(),
    st.sampled_from(["010", "1:30", "0x1f", "yes", "null", "=", "<<", "2026-01-02", ".5", "1e"]),
    st.from_regex(r"[-+]?[0-9]{1,3}e[-+]?[0-9]{1,3}[0-9a-f]{0,3}", fullmatch=True),
)


@given(
    st.dictionaries(
        st.text(min_size=1),
        st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=4), max_leaves=8),
        max_size=6,
    )
)
@settings(max_examples=40)
def test_whatever_is_written_as_yaml_is_read_again(value: dict[str, object]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.yaml"
        write_yaml(path, value)
        found = read_yaml(path)
        assert found.keys() == list(value)
        for key, item in value.items():
            assert found.value(key) == item


@pytest.mark.parametrize("text", ["1e-3", "1.0e-3", "+1E-3", "0.001", ".001", "10e-4", "1e-03"])
def test_numbers_as_people_write_them(text: str, fields: Callable[[str], Fields]) -> None:
    assert fields(f"a: {text}").number("a") == 1e-3


@pytest.mark.parametrize("text", ["12e5" * 16, "3e5f", "1e3a", "e5", "1e", "0e5d-1"])
def test_a_hash_is_no_number(text: str, fields: Callable[[str], Fields]) -> None:
    assert fields(f"a: {text}").text("a") == text


def test_one_value_written_at_two_places_is_no_alias(tmp_path: Path) -> None:
    row = [1.0, 2.0]
    write_yaml(tmp_path / "x.yaml", {"a": row, "b": row})
    np.testing.assert_array_equal(read_yaml(tmp_path / "x.yaml").array("b", (2,)), row)


def test_sha256_of_the_published_example(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"abc")
    assert sha256(tmp_path / "x") == (
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    )


# ---- atomic writes ----------------------------------------------------------------------------

KILLED_WRITER = """
import os, signal, sys
from pathlib import Path
from shoecal_core.files import atomic_write

path, rounds = Path(sys.argv[1]), int(sys.argv[2])
contents = [bytes([65 + k]) * size for k, size in enumerate((10, 300_000, 70_000, 1_500_000))]
atomic_write(path, contents[0])
for round in range(rounds):
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        turn = round
        while True:
            atomic_write(path, contents[turn % len(contents)])
            os.write(write, b".")
            turn += 1
    for _ in range(1 + round % 5):
        os.read(read, 1)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(read), os.close(write)
    print(path.read_bytes() in contents)
"""


def test_a_writer_killed_at_any_moment_leaves_a_whole_file(tmp_path: Path) -> None:
    target = tmp_path / "calibration.yaml"
    done = subprocess.run(
        [sys.executable, "-c", KILLED_WRITER, str(target), "20"],
        check=True, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": _core()},
    )  # fmt: skip
    assert done.stdout.split() == ["True"] * 20
    others = [path.name for path in tmp_path.iterdir() if path != target]
    assert all(name.startswith(".calibration.yaml.") for name in others)


def test_a_file_is_replaced_with_the_rights_of_a_new_one(tmp_path: Path) -> None:
    path = tmp_path / "x"
    atomic_write(path, "old")
    (tmp_path / "plain").touch()
    atomic_write(path, b"n\xffw")
    assert path.read_bytes() == b"n\xffw"
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["plain", "x"]


def test_a_disk_that_fills_up_leaves_the_old_file_alone(tmp_path: Path) -> None:
    path = tmp_path / "x"
    atomic_write(path, "old")
    with file_size_limit(4096):
        problem = refused(path, "", lambda: atomic_write(path, b"n" * 100_000))
    assert "untouched" in problem
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_be_made_durable_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.fsync

    def refuse(file: int) -> None:
        if stat.S_ISDIR(os.fstat(file).st_mode):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        real(file)

    path = tmp_path / "x"
    monkeypatch.setattr(os, "fsync", refuse)
    problem = refused(path, "", lambda: atomic_write(path, "new"))
    assert "may not outlast a power cut" in problem
    assert path.read_text() == "new"


def test_what_is_left_on_a_broken_disk_is_no_second_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    path = tmp_path / "x"
    atomic_write(path, "old")
    for name in ("replace", "unlink"):
        monkeypatch.setattr(os, name, refuse)
    assert "untouched" in refused(path, "", lambda: atomic_write(path, "new"))
    assert path.read_text() == "old"


def test_a_folder_in_the_way_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.mkdir()
    assert "untouched" in refused(path, "", lambda: atomic_write(path, "new"))
    assert list(tmp_path.iterdir()) == [path]
    assert "cannot be written" in refused(Path(), "", lambda: atomic_write(Path(), "new"))


def test_a_missing_folder_and_a_file_for_a_folder_are_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for folder in ("none", "file"):
        path = tmp_path / folder / "x"
        assert "check the folder" in refused(path, "", partial(atomic_write, path, "a"))


def test_a_read_only_folder_is_refused() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x"
        path.write_text("old")
        Path(folder).chmod(0o555)
        with ordinary_user():
            assert "Permission denied" in refused(path, "", lambda: atomic_write(path, "new"))
        assert path.read_text() == "old"
        assert list(Path(folder).iterdir()) == [path]


def _core() -> str:
    return str(Path(__file__).parents[2] / "shoecal_core")


# ---- errors -----------------------------------------------------------------------------------

ERRORS = (
    ShoecalError("plain"),
    FileError("robot.yaml", "is missing; add it", field="weight.mass_kg"),
    FileError(Path("a\nb"), "of two\r\nlines\x85or\u2028three"),
    VersionError("x.yaml", 7, 2),
    NameNotFoundError("joint", "Knee", ("LKnee", "RKnee")),
    NameNotFoundError("joint", "Knee", ()),
    ShapeError("readings", "(T, 8)", (3, 4)),
)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_is_one_line_and_crosses_processes_whole(error: ShoecalError) -> None:
    assert len(str(error).splitlines()) == 1
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert copy.__dict__ == error.__dict__


def test_a_text_of_anybody_becomes_one_line_of_bounded_length() -> None:
    assert one_line("of two\r\nlines, \x1b[2J") == "of two lines, \ufffd[2J"
    long = one_line("\x00" * 10**6 + "; plug it in again")
    assert len(long) <= LONGEST
    assert long.isprintable()
    assert long.endswith("; plug it in again"), "the cure stays"


def test_messages_tell_what_was_expected_and_what_there_is() -> None:
    texts = list(map(str, ERRORS))
    assert texts[1] == "robot.yaml: weight.mass_kg: is missing; add it"
    assert texts[4] == "no joint named 'Knee' (did you mean 'RKnee'? there are: LKnee, RKnee)"
    assert texts[5] == "no joint named 'Knee' (there are: none)"
    assert texts[6] == "readings: expected shape (T, 8), got (3, 4)"


def test_a_date_is_told_as_what_it_is(fields: Callable[[str], Fields]) -> None:
    found = fields("a: 2026-01-02")
    assert found.value("a") == datetime.date(2026, 1, 2)
