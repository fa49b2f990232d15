"""Some mutants of every kind of file, and mutants that load wrongly, which must be noticed."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from reliability import loading, mcap_mutations, mutations, originals
from reliability.mutants import ROWS
from reliability.mutated_files import CONFIGURATION, lay_config
from reliability.row import Result, Row
from shoecal_core.errors import FileError, FileMissingError, ShoecalError, error_code

CODES = frozenset({error_code(FileMissingError)})


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.key)
def test_a_mutant_is_refused_or_loads_as_it_says(row: Row) -> None:
    done: list[int] = []
    found = row.run(0, 60, 1, done.append)
    assert (found.tried, found.failed) == (60, 0), found.worst
    assert done == list(range(1, 61))


def test_a_mutant_depends_on_seed_and_number_alone(tmp_path: Path) -> None:
    def mutant(folder: Path, *numbers: int) -> dict[Path, bytes]:
        draw = lay_config(CONFIGURATION, mutations.mutate_yaml, folder)
        for number in numbers:
            draw(np.random.default_rng([1, number]))
        names = (folder / "config" / name for name in CONFIGURATION)
        return {path.relative_to(folder): path.read_bytes() for path in names}

    folder = tmp_path / "mutants"
    folder.mkdir()
    alone = mutant(folder, 7)
    folder.rename(tmp_path / "before")
    folder.mkdir()
    assert mutant(folder, 5, 6, 7) == alone


def test_an_integer_that_no_float_holds_is_mutated_too(tmp_path: Path) -> None:
    for seed in range(100):
        mutations.mutate_yaml(b"mass: 1" + 400 * b"0", np.random.default_rng(seed), tmp_path)


def test_what_is_not_mutated_stays(tmp_path: Path) -> None:
    """A file that is taken apart and put together again is the same."""
    run = originals.session(tmp_path / "session", runs=1).runs[0].path.read_bytes()
    assert mcap_mutations._file(mcap_mutations._outer(run)) == run
    robot = ElementTree.parse(originals.URDF).getroot()
    for element in robot.iter():
        element.text = element.tail = None
        for name, text in element.attrib.items():
            element.set(name, " ".join(text.split()))
    again = mutations._element(mutations._plain(robot))
    assert ElementTree.tostring(again) == ElementTree.tostring(robot)


def test_codes_say_what_is_wrong() -> None:
    """No row accepts the codes of any error whatever."""
    for row in ROWS:
        codes = row.run.args[1]  # type: ignore[attr-defined]
        assert codes
        assert not codes & {error_code(one) for one in (ShoecalError, FileError)}


def test_a_refusal_is_one_that_names_the_file_with_a_code_of_its_kind(tmp_path: Path) -> None:
    def wrong(error: ShoecalError) -> str:
        return loading._wrong_refusal(error, CODES, tmp_path)

    path = tmp_path / "file"
    assert not wrong(FileMissingError(path, "is missing"))
    assert "not name the file" in wrong(FileMissingError("file", "is missing"))
    assert "the code file:" in wrong(FileError(path, "is odd"))
    late = FileMissingError(path, "is missing")
    late.__cause__ = MemoryError()
    assert "more memory" in wrong(late)


BAD_FILES = """\
import os
import signal
from pathlib import Path

from reliability.loading import WrongLoadError

def died(folder):
    return lambda rng: lambda: os.kill(os.getpid(), signal.SIGPROF)

def hoarded(folder):
    return lambda rng: lambda: bytearray(2**31 + 2**20)

def waited(folder):
    return lambda rng: (folder / "trap").read_bytes

def wrong(folder):
    def load():
        raise WrongLoadError("other numbers")
    return lambda rng: load

def ran(folder):
    return lambda rng: (folder / "canary").touch

def started(folder):
    return lambda rng: lambda: os.system("true")

def opened(folder):
    return lambda rng: Path("/etc/passwd").read_bytes

def broken(folder):
    raise ValueError("no whole file")
"""
"""A module, since a new process imports what it runs."""


@pytest.fixture
def lays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], loading.Lay]:
    (tmp_path / "bad_files.py").write_text(BAD_FILES)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "bad_files", raising=False)
    return lambda name: getattr(importlib.import_module("bad_files"), name)


@pytest.mark.parametrize(
    ("name", "failed"),
    [
        ("died", "its process died: more than 10 s of the processor"),
        ("hoarded", "MemoryError: "),
        ("waited", "its process died: it waited for more than 2 s"),
        ("wrong", "loaded wrongly: other numbers"),
        ("ran", "code of the file ran"),
        ("started", "os.system(b'true',)"),
        ("opened", "opens /etc/passwd"),
    ],
)
def test_what_a_load_must_not_do_fails_and_the_next_mutant_is_tried(
    lays: Callable[[str], loading.Lay], monkeypatch: pytest.MonkeyPatch, name: str, failed: str
) -> None:
    monkeypatch.setattr(loading, "SILENCE_S", 2.0)
    found = loading.try_mutants(lays(name), CODES, 3, 2, 0, lambda _: None)
    assert found == Result(2, 2, f"mutant 3: {failed}", found.figure, {"refused": 0})


def test_whole_files_that_do_not_load_are_an_error(lays: Callable[[str], loading.Lay]) -> None:
    with pytest.raises(RuntimeError, match="whole files cannot be loaded: exit code 1"):
        loading.try_mutants(lays("broken"), CODES, 0, 2, 0, lambda _: None)
