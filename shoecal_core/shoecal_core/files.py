"""Reading and writing files so that nothing is lost and nothing is guessed.

`Fields` walks a parsed YAML mapping and turns whatever is missing or wrong into one
`FieldError` that names the file and the dotted field.
"""

from __future__ import annotations

import errno
import hashlib
import math
import os
import re
import secrets
import stat
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path
from typing import Any, cast

import numpy as np
import yaml

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import (
    DiskFullError,
    FieldError,
    FileError,
    FileMissingError,
    FileSyntaxError,
    FileTakenError,
    FileTooLargeError,
    FileUnreadableError,
    FileUnwritableError,
    VersionError,
)
from shoecal_core.file_kinds import DECIMAL_POINT, NODES, kind_of, meant, not_yaml, wanted

MAX_BYTES = 512 * 2**20
"""Larger files are refused before they are read into memory."""
MAX_YAML_BYTES = 2**20
MAX_YAML_VALUES = 100_000
"""Larger configuration files are refused: to parse them would take very long."""

_BY_NUMBER: Mapping[int | None, type[FileError]] = {
    errno.ENOENT: FileMissingError,
    errno.EEXIST: FileTakenError,
    errno.ENOSPC: DiskFullError,
    errno.EDQUOT: DiskFullError,
    errno.EFBIG: DiskFullError,
}
"""What these numbers mean, whatever was to be done; all others depend on that."""


def system_error(
    path: Path | str,
    error: OSError,
    problem: str,
    cure: str = "",
    *,
    otherwise: type[FileError] = FileUnwritableError,
) -> FileError:
    """What the operating system refuses, as an error by what a program can do about it.

    Args:
        path: the file or folder.
        error: of the system.
        problem: what could not be done with it: cannot be written, made, …
        cure: for a person.
        otherwise: the error unless it is missing, is there already, or there is no room.
    """
    text = f"{problem} ({error.strerror or error})"
    kind = _BY_NUMBER.get(error.errno, otherwise)
    return kind(path, f"{text}; {cure}" if cure else text)


def read_error(path: Path | str, error: OSError, cure: str = "") -> FileError:
    """Likewise where a file was to be read."""
    return system_error(path, error, "cannot be read", cure, otherwise=FileUnreadableError)


def make_folder(folder: Path, cure: str = "") -> None:
    """Make a folder, and those above it, where there is none.

    Args:
        folder: to be made.
        cure: for a person, where it cannot be.

    Raises:
        FileTakenError: a file stands in its place.
        DiskFullError: there is no room.
        FileUnwritableError: the folder above it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise system_error(folder, error, "cannot be made", cure) from error


def atomic_write(path: Path, content: bytes | str, mode: int = 0o666) -> None:
    """Write a file so that after a kill at any moment it is the old one or the new one, whole.

    Args:
        path: the file.
        content: of it.
        mode: rights of the file, less those that the process's umask takes away.

    Raises:
        FileMissingError: when the folder does not exist.
        DiskFullError: when there is no room.
        FileUnwritableError: when it cannot be written otherwise; also when only the folder
            cannot be made durable: then the new file stands, for as long as there is power.
    """
    path = Path(path)
    data = content.encode() if isinstance(content, str) else content
    fresh = path.parent / f".{path.name}.{secrets.token_hex(8)}"
    try:
        file = os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb")
    except OSError as error:
        cure = "check the folder and its rights"
        raise system_error(path, error, "cannot be written", cure) from error
    try:
        with file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        fresh.replace(path)
    except OSError as error:
        cure = "the file before it is untouched"
        raise system_error(path, error, "cannot be written", cure) from error
    finally:
        with suppress(OSError):  # a disk that refuses this has refused the file before
            fresh.unlink(missing_ok=True)
    sync_folder(path)


def sync_folder(path: Path) -> None:
    """Make durable that a file came into its folder, or left it; FileError where that fails."""
    try:
        handle = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        problem = "may not outlast a power cut: its folder cannot be made durable"
        raise system_error(path, error, problem, "check the disk") from error


def sha256(path: Path) -> str:
    """Hexadecimal SHA-256 of a file's content."""
    with open_file(path) as file, _refused(path):
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_bytes(path: Path, largest: int = MAX_BYTES) -> bytes:
    """Content of a file.

    Args:
        path: the file.
        largest: bytes that it may have.

    Raises:
        FileTooLargeError: where it has more.
        FileMissingError, FileUnreadableError: as `open_file`.
    """
    with open_file(path) as file, _refused(path):
        if os.fstat(file.fileno()).st_size > largest:
            problem = f"larger than {largest >> 20} MiB; not a file of this kind"
            raise FileTooLargeError(path, problem)
        return file.read()


def open_file(path: Path) -> BufferedReader:
    """A file, opened for reading.

    Raises:
        FileMissingError: where there is none.
        FileUnreadableError: where it cannot be opened, or is a folder, or a pipe or a device:
            they may have no end.
    """
    with _refused(path):
        # Opening a pipe waits for its writer, unless asked not to wait.
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(file).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(file, "rb")
    os.close(file)
    problem = os.strerror(errno.EISDIR) if stat.S_ISDIR(mode) else "a pipe or a device"
    raise FileUnreadableError(path, f"cannot be read ({problem}); name a plain file")


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """What the system refuses, as a FileError."""
    try:
        yield
    except OSError as error:
        raise read_error(path, error) from error
    except ValueError as error:  # a NUL in the name
        raise FileUnreadableError(path, f"cannot be read ({error})") from error


def read_yaml(path: Path) -> Fields:
    """Read a YAML mapping, safely: no code runs, no alias bomb unfolds, no number is guessed.

    Raises:
        FileSyntaxError: where it is no YAML, or no mapping.
        FileMissingError, FileUnreadableError, FileTooLargeError: as `read_bytes`.
    """
    content = read_bytes(path, MAX_YAML_BYTES)
    try:
        value = yaml.load(content, Loader=_Loader)  # noqa: S506 - a child of SafeLoader
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        if kind := not_yaml(content):
            raise FileSyntaxError(path, kind) from error
        mark, problem = (getattr(error, name, None) for name in ("problem_mark", "problem"))
        line = f" at line {mark.line + 1}" if mark is not None else ""
        reason = f" ({problem})" if problem else ""
        tab = problem is not None and r"'\t'" in problem
        cure = "indent with spaces, not with tabs" if tab else "correct it there"
        raise FileSyntaxError(path, f"not valid YAML{line}{reason}; {cure}") from error
    if not isinstance(value, dict):
        problem = not_yaml(content) or "expected a mapping of keys to values at the top level"
        raise FileSyntaxError(path, problem)
    return Fields(Path(path), "", value)


def file_kind(path: Path) -> str:
    """The kind of a YAML file by its keys; empty where it has none, or cannot be read."""
    try:
        return kind_of(read_yaml(path).keys(), ())
    except FileError:
        return ""


def write_yaml(path: Path, value: Mapping[str, object]) -> None:
    """Write a mapping as YAML, atomically, keys in the order given."""
    atomic_write(path, yaml_text(value))


def yaml_text(value: Mapping[str, object]) -> str:
    """A mapping as YAML, keys in the order given."""
    text = yaml.dump(
        dict(value), Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=100
    )
    return str(text)


class Fields:
    """One mapping of a file, read field by field with errors that name the field."""

    def __init__(self, path: Path, prefix: str, values: Mapping[object, object]) -> None:
        self.path = path
        self.prefix = prefix
        self._values = values

    def __contains__(self, key: str) -> bool:
        return self._values.get(key) is not None

    def keys(self) -> list[str]:
        """Keys present, as text."""
        return [str(key) for key in self._values]

    def error(self, key: str, problem: str) -> FieldError:
        """The error to raise for one field."""
        return FieldError(self.path, problem, field=self._name(key))

    def only(self, *known: str) -> None:
        """Refuse unknown keys: a typo must not silently become a default."""
        for key in self.keys():
            if key in known:
                continue
            if not self.prefix and (kind := kind_of(self.keys(), known)):
                raise FieldError(self.path, f"is {kind}, by its keys; {wanted(known)}")
            raise self.error(key, f"unknown key; {meant(key, known)}")

    def format(self, known: int) -> int:
        """Check the file's version."""
        if "format" not in self and kind_of(self.keys(), ()) == NODES:
            raise FieldError(self.path, f"is {NODES}, by its keys; {wanted(())}")
        version = self.integer("format")
        if version > known:
            raise VersionError(self.path, version, known)
        if version < 1:
            raise self.error("format", f"must be 1 to {known}")
        return version

    def value(self, key: str) -> object:
        """A required value of any kind."""
        if key not in self:
            raise self.error(key, "is missing; add it")
        return self._values[key]

    def text(self, key: str, default: str | None = None) -> str:
        """A string."""
        if default is not None and key not in self:
            return default
        value = self.value(key)
        if not isinstance(value, str):
            raise self.error(key, f"expected text, got {_shown(value)}")
        return value

    def boolean(self, key: str) -> bool:
        """True or false."""
        value = self.value(key)
        if not isinstance(value, bool):
            raise self.error(key, f"expected true or false, got {_shown(value)}")
        return value

    def integer(self, key: str, default: int | None = None, *, minimum: int | None = None) -> int:
        """A whole number."""
        if default is not None and key not in self:
            return default
        value = self.value(key)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"expected a whole number, got {_shown(value)}")
        if minimum is not None and value < minimum:
            raise self.error(key, f"must be at least {minimum}, got {value}")
        return value

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        minimum: float = -math.inf,
        above: float = -math.inf,
        maximum: float = math.inf,
    ) -> float:
        """A finite number within bounds."""
        if default is not None and key not in self:
            return default
        value = self._finite(key, self.value(key))
        if value < minimum or value <= above or value > maximum:
            low = f"at least {minimum:g}" if minimum > -math.inf else ""
            low = f"above {above:g}" if above > -math.inf else low
            high = f"at most {maximum:g}" if maximum < math.inf else ""
            bounds = " and ".join(filter(None, (low, high)))
            raise self.error(key, f"must be {bounds}, got {value:g}")
        return value

    def array(self, key: str, shape: tuple[int | None, ...]) -> FloatArray:
        """Finite numbers of a given shape, None for any length: (None, 3) for (n, 3)."""
        value = self.value(key)
        flat = [self._finite(key, item) for item in _flatten(value)]
        try:
            array = np.asarray(value, dtype=np.float64)
        except (ValueError, TypeError) as error:
            raise self.error(key, "expected numbers in rows of equal length") from error
        fits = array.ndim == len(shape) and all(
            want is None or want == got for want, got in zip(shape, array.shape, strict=True)
        )
        if not fits or array.size != len(flat):
            wanted = " x ".join("n" if want is None else str(want) for want in shape)
            raise self.error(key, f"expected {wanted} numbers, got shape {array.shape}")
        return array

    def mapping(self, key: str) -> Fields:
        """A nested mapping."""
        value = self.value(key)
        if not isinstance(value, dict):
            raise self.error(key, "expected a mapping of keys to values")
        return Fields(self.path, self._name(key), value)

    def items(self, key: str) -> list[Fields]:
        """A list of mappings."""
        value = self.value(key)
        if not isinstance(value, list):
            raise self.error(key, "expected a list")
        for index, item in enumerate(value):
            if not isinstance(item, dict):
                raise self.error(f"{key}[{index}]", "expected a mapping of keys to values")
        return [
            Fields(self.path, f"{self._name(key)}[{index}]", item)
            for index, item in enumerate(value)
        ]

    def texts(self, key: str) -> list[str]:
        """A list of strings."""
        value = self.value(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.error(key, "expected a list of names")
        return cast(list[str], value)

    def choice(self, key: str, choices: Mapping[str, object]) -> str:
        """One of a few names."""
        value = self.text(key)
        if value not in choices:
            raise self.error(key, f"'{value}' is not one of: {', '.join(choices)}")
        return value

    def _name(self, key: str) -> str:
        return f"{self.prefix}.{key}" if self.prefix else key

    def _finite(self, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            comma = isinstance(value, str) and _COMMA.fullmatch(value.strip())
            cure = f"; {DECIMAL_POINT}" if comma else ""
            raise self.error(key, f"expected a number (like 1.5e-3), got {_shown(value)}{cure}")
        try:
            number = float(value)
        except OverflowError as error:
            raise self.error(key, "number too large") from error
        if not math.isfinite(number):
            raise self.error(key, f"expected a finite number, got {value:g}")
        return number


class _Dumper(yaml.SafeDumper):
    """Writes a value wherever it stands: an alias would not be read again."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002
        return True


class _Loader(yaml.SafeLoader):
    """Safe loader of plain data: everything that would surprise its author is refused.

    No aliases (a few bytes must not unfold into gigabytes), no tags, no key twice, and no
    number that YAML 1.1 reads otherwise than a person does (010 is 8 there, and 1:30 is 90).
    """

    _values = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        self._values += 1
        if self._values > MAX_YAML_VALUES:
            raise yaml.composer.ComposerError(
                None, None, f"more than {MAX_YAML_VALUES} values", event.start_mark
            )
        for kind, found in (
            ("aliases", isinstance(event, yaml.AliasEvent)),
            ("tags", getattr(event, "tag", None) is not None),
        ):
            if found:
                raise yaml.composer.ComposerError(
                    None, None, f"{kind} are not allowed", event.start_mark
                )
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"key {_shown(key.value)} stands twice", key.start_mark
                    )
                seen.add(key.value)
        return super().construct_mapping(node, deep)

    def construct_number(self, node: yaml.ScalarNode) -> int | float:
        """A number as a person reads it."""
        if not _NUMBER.fullmatch(node.value):
            raise yaml.constructor.ConstructorError(
                None, None, f"{_shown(node.value)} is no plain decimal number", node.start_mark
            )
        whole = node.tag == _INTEGER
        construct = self.construct_yaml_int if whole else self.construct_yaml_float
        return construct(node)


_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+")
_INTEGER, _FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"
_NUMBER = re.compile(
    r"[-+]?(0|[1-9][0-9]*)?(\.[0-9]*)?(e[-+]?[0-9]+)?|[-+]?\.(inf|nan)", re.IGNORECASE
)
# YAML 1.1 takes 1e-5 for a text: it wants a point. The dumper must know too, or it would write a
# text like that (a hash of such digits) without quotes.
_POINTLESS = re.compile(r"[-+]?[0-9]+e[-+]?[0-9]+$", re.IGNORECASE)
for _side in (_Loader, _Dumper):
    _side.add_implicit_resolver(_FLOAT, _POINTLESS, list("-+0123456789"))
for _tag in (_INTEGER, _FLOAT):
    _Loader.add_constructor(_tag, _Loader.construct_number)


def _flatten(value: object) -> Iterator[object]:
    if isinstance(value, list):
        for item in value:
            yield from _flatten(item)
    else:
        yield value


def _shown(value: object) -> str:
    """A value for a message, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
