"""Libraries: made once, kept privately, never loaded damaged."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.compile_cache import libraries, program
from shoecal_core import compiler
from shoecal_core.compiler import CompilerError, cache_folder, find_compiler, library

SOURCE = "double twice(double x) { return 2.0 * x; }"


def twice(file: Path) -> float:
    function = ctypes.CDLL(str(file)).twice
    function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
    return float(function(21.0))


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that gains a line whenever something is compiled."""
    log = tmp_path / "calls"
    log.touch()
    script = f'case "$*" in *--version) ;; *) echo "$*" >> {log};; esac\nexec cc "$@"'
    monkeypatch.setenv("CC", program(tmp_path / "counted", script))
    return log


def count(calls: Path) -> int:
    return len(calls.read_text().splitlines())


def test_a_source_is_compiled_once(library_cache: Path, calls: Path) -> None:
    file = library(SOURCE)
    assert file.parent == library_cache == cache_folder()
    assert twice(file) == 42.0
    assert library(SOURCE) == file
    assert count(calls) == 1
    assert [file] == libraries(library_cache)
    assert library_cache.stat().st_mode & 0o777 == 0o700
    assert file.stat().st_mode & 0o777 == 0o600


def test_another_source_compiler_flag_or_processor_is_another_library(
    library_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [library(SOURCE), library(SOURCE.replace("2.0", "3.0"))]
    monkeypatch.setenv("CC", "cc -DANOTHER")
    files.append(library(SOURCE))
    monkeypatch.setattr(compiler, "_FLAGS", (*compiler._FLAGS, "-O0"))
    files.append(library(SOURCE))
    monkeypatch.setattr(compiler, "_processor", lambda: "another")
    files.append(library(SOURCE))
    assert len(set(files)) == 5
    assert libraries(library_cache) == sorted(files)


@pytest.mark.parametrize("damage", ["cut", "half", "empty", "flipped", "longer", "link", "folder"])
def test_a_damaged_library_is_made_anew(library_cache: Path, calls: Path, damage: str) -> None:
    file = library(SOURCE)
    content = file.read_bytes()
    file.unlink()
    if damage == "link":
        file.symlink_to(library_cache / "elsewhere.so")
        (library_cache / "elsewhere.so").write_bytes(content)
    elif damage == "folder":
        file.mkdir()
        with pytest.raises(CompilerError, match="cannot be written"):
            library(SOURCE)
        return
    else:
        middle = len(content) // 2
        flipped = bytes([content[middle] ^ 1])
        file.write_bytes(
            {
                "cut": content[:-1],
                "half": content[:middle],
                "empty": b"",
                "flipped": content[:middle] + flipped + content[middle + 1 :],
                "longer": content + b"\0",
            }[damage]
        )
        file.chmod(0o600)
    assert library(SOURCE).read_bytes() == content
    assert count(calls) == 2
    assert not file.is_symlink()


def test_a_library_that_others_could_have_written_is_made_anew(
    library_cache: Path, calls: Path
) -> None:
    file = library(SOURCE)
    file.chmod(0o602)
    assert library(SOURCE).stat().st_mode & 0o777 == 0o600
    assert count(calls) == 2


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives files away")
def test_a_library_or_a_folder_of_another_user(library_cache: Path, calls: Path) -> None:
    file = library(SOURCE)
    os.chown(file, 65534, -1)
    assert library(SOURCE).stat().st_uid == os.getuid()
    assert count(calls) == 2
    os.chown(library_cache, 65534, -1)
    with pytest.raises(CompilerError, match="another user"):
        library(SOURCE)


@pytest.mark.parametrize("rights", [0o777, 0o770, 0o702])
def test_a_folder_that_others_can_write_is_refused(library_cache: Path, rights: int) -> None:
    library(SOURCE)
    library_cache.chmod(rights)
    with pytest.raises(CompilerError, match=r"another user.*700"):
        library(SOURCE)


def test_a_cache_that_cannot_be_made(
    library_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "cache").write_text("a file")
    with pytest.raises(CompilerError, match="cannot be made"):
        library(SOURCE)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # to be ignored, says the standard
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "shoecal"


@pytest.mark.skipif(os.getuid() == 0, reason="root writes everywhere")
def test_a_read_only_cache_still_serves(library_cache: Path) -> None:
    file = library(SOURCE)
    library_cache.chmod(0o500)
    assert library(SOURCE) == file
    with pytest.raises(CompilerError, match="cannot be written"):
        library(SOURCE.replace("2.0", "3.0"))


def test_compilers_that_do_not_work(
    library_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(named: str, reason: str) -> None:
        monkeypatch.setenv("CC", named)
        with pytest.raises(CompilerError, match=reason) as caught:
            library(SOURCE)
        assert len(str(caught.value).splitlines()) == 1

    refused("no-such-compiler", "no-such-compiler.*no program")
    refused('cc "', "CC.*quotation")
    complaint = "printf 'a.c:1: error: too old\\n  ^~~' >&2; exit 1"
    refused(program(tmp_path / "strict", complaint), "too old")
    refused(program(tmp_path / "broken", "echo bad luck >&2; exit 3"), "broken.*bad luck")
    refused(program(tmp_path / "silent", "exit 3"), "silent.*exit code 3")
    refused(program(tmp_path / "idle", "exit 0"), "idle.*nothing made")
    refused(program(tmp_path / "odd", 'case "$*" in *--version) ;; *) exit 7;; esac'), "code 7")
    (tmp_path / "text").write_text("no program")
    (tmp_path / "text").chmod(0o700)
    refused(str(tmp_path / "text"), "does not run")
    monkeypatch.setattr(compiler, "_PATIENCE", 0.05)
    refused(program(tmp_path / "slow", "exec sleep 5"), "more than 0.05 s")
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(CompilerError, match="no C compiler"):
        find_compiler()
    assert libraries(library_cache) == []


def test_the_oldest_libraries_are_removed(
    library_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [library(SOURCE.replace("2.0", f"{number}.0")) for number in range(4)]
    for age, file in enumerate(files):
        os.utime(file, (1e9 - age, 1e9 - age))
    (library_cache / ".left.so.behind").write_text("by a process that was killed")
    os.utime(library_cache / ".left.so.behind", (0, 0))
    library(SOURCE.replace("2.0", "3.0"))  # used again: the oldest no more
    monkeypatch.setattr(compiler, "_CACHE_BYTES", int(3.5 * files[0].stat().st_size))
    fresh = library(SOURCE.replace("2.0", "5.0"))
    assert libraries(library_cache) == sorted([fresh, files[3], files[0]])


def test_many_processes_at_once(library_cache: Path) -> None:
    code = "import sys; from shoecal_core.compiler import library; print(library(sys.argv[1]))"
    running = [
        subprocess.Popen([sys.executable, "-c", code, SOURCE], stdout=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    told = {process.communicate()[0].strip() for process in running}
    assert all(process.returncode == 0 for process in running)
    assert [str(file) for file in libraries(library_cache)] == sorted(told)
    assert twice(Path(told.pop())) == 42.0
