"""C source to shared library: the system's compiler, and a cache of what it made.

The cache is `$XDG_CACHE_HOME/shoecal` (`~/.cache/shoecal`). Code is loaded from it, so it is
private, and each library carries a digest of itself: loading a damaged one would end the process.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import platform
import re
import shlex
import shutil
import stat
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.files import atomic_write

SWITCH = "SHOECAL_COMPILE"
"""Environment variable; 0 switches compilation off."""

_NAMES = ("cc", "gcc", "clang")
_TUNED = "-march=native" if platform.machine() in {"x86_64", "AMD64"} else "-mcpu=native"
_FLAGS = ("-O1", _TUNED, "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-shared", "-w")
"""No higher level: for the planner's 15000 statements in a row it takes twice as long, and the code
is not faster. Products and sums are not contracted: values agree with the source's.
"""
_PATIENCE = 600.0
"""s for one source; a whole optimisation problem takes minutes."""
_CACHE_BYTES = 64 * 2**20
_DIGEST = hashlib.sha256().digest_size


class CompilerError(ShoecalError):
    """A source that could not be made into a library, and why."""


@dataclass(frozen=True)
class Compiler:
    """The system's C compiler.

    Attributes:
        command: program and its own arguments.
        version: as it tells.
    """

    command: tuple[str, ...]
    version: str


def switched_off() -> bool:
    """Does the environment say that nothing is to be compiled?"""
    return os.environ.get(SWITCH, "") == "0"


def find_compiler() -> Compiler:
    """$CC where it is set, else the first of cc, gcc and clang.

    Raises:
        CompilerError: where there is none, or it does not run.
    """
    named = os.environ.get("CC", "")
    return _found(named, os.environ.get("PATH", ""))


@functools.cache
def _found(named: str, path: str) -> Compiler:
    try:
        wanted, *arguments = shlex.split(named) or [""]
    except ValueError as error:
        raise CompilerError(f"CC is '{named}' ({error})") from error
    programs = (shutil.which(name, path=path) for name in ([wanted] if wanted else _NAMES))
    program = next(filter(None, programs), None)
    if program is None and wanted:
        raise CompilerError(f"CC names '{wanted}', which is no program")
    if program is None:
        raise CompilerError(f"there is no C compiler ({', '.join(_NAMES)})")
    said = _run([program, *arguments, "--version"])
    return Compiler((program, *arguments), said.splitlines()[0] if said else "")


def cache_folder() -> Path:
    """Where compiled libraries are kept; it need not exist."""
    named = os.environ.get("XDG_CACHE_HOME", "")
    try:
        base = Path(named) if Path(named).is_absolute() else Path.home() / ".cache"
    except RuntimeError as error:
        raise CompilerError("there is no home folder for compiled functions") from error
    return base / "shoecal"


def library(source: str, *flags: str) -> Path:
    """The shared library of a C source: from the cache, else compiled and put there.

    Args:
        source: C.
        flags: for the compiler, behind those of every source.

    Raises:
        CompilerError: where there is no compiler, it fails, or the cache cannot be used.
    """
    compiler = find_compiler()
    folder = _private_folder()
    command = (*compiler.command, *_FLAGS, *flags)
    made_of = (source, *command, compiler.version, _processor(), ca.CasadiMeta.version())
    key = hashlib.sha256("\0".join(made_of).encode()).hexdigest()[:32]
    file = folder / f"{key}.so"
    if _is_sound(file):
        with contextlib.suppress(OSError):  # a read-only cache will do
            os.utime(file)
        return file
    if not os.access(folder, os.W_OK):
        raise CompilerError(f"{folder}: cannot be written; check its rights")
    code = _compile(command, source)
    try:
        atomic_write(file, code + hashlib.sha256(code).digest(), mode=0o600)
    except FileError as error:
        raise CompilerError(str(error)) from error
    _remove_oldest(folder)
    return file


def _private_folder() -> Path:
    folder = cache_folder()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.stat()
    except OSError as error:
        raise CompilerError(f"{folder}: cannot be made ({error.strerror})") from error
    if not _is_private(status):
        raise CompilerError(
            f"{folder}: belongs to or can be written by another user, so no code is loaded from "
            "it; own it and set its rights to 700"
        )
    return folder


def _is_private(status: os.stat_result) -> bool:
    others = stat.S_IWGRP | stat.S_IWOTH
    return status.st_uid == os.getuid() and not status.st_mode & others


def _is_sound(file: Path) -> bool:
    """Is it ours alone, and as long and as it was written? A linker ignores what follows a library,
    so the digest stands at its end and the two cannot part.
    """
    try:
        if not _is_private(file.lstat()):
            return False
        content = file.read_bytes()
    except OSError:
        return False
    return hashlib.sha256(content[:-_DIGEST]).digest() == content[-_DIGEST:]


def _compile(command: Sequence[str], source: str) -> bytes:
    try:
        with tempfile.TemporaryDirectory(prefix="shoecal-") as folder:
            text, made = Path(folder) / "source.c", Path(folder) / "source.so"
            text.write_text(source)
            _run([*command, "-o", str(made), str(text), "-lm"])
            return made.read_bytes()
    except OSError as error:
        raise CompilerError(f"{command[0]}: nothing made ({error.strerror})") from error


def _run(command: Sequence[str]) -> str:
    """What a program prints, in English; CompilerError where it fails."""
    try:
        done = subprocess.run(
            command,
            check=True,
            capture_output=True,
            timeout=_PATIENCE,
            stdin=subprocess.DEVNULL,
            env=os.environ | {"LC_ALL": "C"},
        )
    except subprocess.CalledProcessError as error:
        told = error.stderr.decode(errors="replace").strip().splitlines()
        telling = [line for line in told if "error" in line] or told[-1:]
        reason = telling[0].strip() if telling else f"exit code {error.returncode}"
        raise CompilerError(f"{command[0]} fails ({reason})") from error
    except subprocess.TimeoutExpired as error:
        raise CompilerError(f"{command[0]} takes more than {_PATIENCE:g} s") from error
    except OSError as error:
        raise CompilerError(f"{command[0]} does not run ({error.strerror})") from error
    return done.stdout.decode(errors="replace")


@functools.cache
def _processor() -> str:
    """What the code is tuned for; another machine may share the home folder."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    wanted = re.compile(r"model name|flags|Features|CPU (implementer|part|variant)")
    return "\n".join(dict.fromkeys(line for line in lines if wanted.match(line)))


def _remove_oldest(folder: Path) -> None:
    """Keep what was used last, within bounds; files that others remove meanwhile are no matter."""
    used = []
    for file in folder.glob("*.so*"):
        try:
            status = file.lstat()
        except OSError:
            continue
        used.append((status.st_mtime, status.st_size, file))
    total = 0
    for _, size, file in sorted(used, reverse=True):
        total += size
        if total > _CACHE_BYTES:
            file.unlink(missing_ok=True)
