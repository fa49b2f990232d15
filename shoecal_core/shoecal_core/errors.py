"""Errors that a user can act on: each message is one line that names the place and the cure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path

LONGEST = 2000
"""Letters of a message; what is put into it may be of any length."""


def one_line(text: str) -> str:
    """A text without line breaks and control characters, its middle left out where too long.

    The end stays: it names the cure.
    """
    if len(text) > LONGEST:
        half = LONGEST // 2 - 2
        text = f"{text[:half]} … {text[-half:]}"
    if text.isprintable():
        return text
    line = " ".join(text.splitlines())
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in line)


class ShoecalError(Exception):
    """Root of every error this project raises on purpose.

    Its message is one line of text, whatever was put into it, and it survives the way from one
    process to another with all of its attributes.
    """

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))

    def __reduce__(self) -> tuple[object, ...]:
        return _revive, (type(self), self.args), self.__dict__


class FileError(ShoecalError):
    """A file that cannot be used: names the file, the field and the cure.

    Subclasses say what is wrong with it, each with a code of its own.

    Attributes:
        path: the file.
        field: dotted path of the offending field, empty for the file as a whole.
    """

    def __init__(self, path: Path | str, problem: str, *, field: str = "") -> None:
        self.path = Path(path)
        self.field = field
        self.problem = problem
        where = f"{path}: {field}" if field else f"{path}"
        super().__init__(f"{where}: {problem}")


class FileMissingError(FileError):
    """A file or folder that is not there.

    Attributes:
        named: files and folders that were named together with it: it is none of them.
    """

    named: tuple[Path, ...] = ()


@contextmanager
def named_together(paths: Iterable[Path]) -> Iterator[None]:
    """Files and folders that one list or command names: none is meant by another one's name."""
    try:
        yield
    except FileMissingError as error:
        error.named += tuple(paths)
        raise


class FileTakenError(FileError):
    """A file or folder that is there already and is not overwritten."""


class FileUnreadableError(FileError):
    """A file that the system does not let be read, or that is no plain file."""


class FileUnwritableError(FileError):
    """A file or folder that the system does not let be written."""


class DiskFullError(FileUnwritableError):
    """A file for which there is no room: the disk is full, or all that is allowed is used up."""


class FileTooLargeError(FileError):
    """A file that is larger than any of its kind."""


class FileSyntaxError(FileError):
    """A file that is not of its kind at all: no YAML, XML, JSON, CSV or Python where one is due."""


class FieldError(FileError):
    """A field or line of a file that is missing, unknown or wrong, or contradicts another one."""


class VersionError(FileError):
    """A file written by a newer version of this software."""

    def __init__(self, path: Path | str, found: object, known: int) -> None:
        self.found = found
        self.known = known
        super().__init__(
            path,
            f"version {found} is not known here (newest known: {known}); update shoecal",
            field="format",
        )


def instead(name: str, available: Sequence[str]) -> str:
    """What a name that does not exist may have been meant for, and what there is."""
    near = get_close_matches(name, available, n=1)
    hint = f"did you mean '{near[0]}'? " if near else ""
    return f"{hint}there are: {', '.join(available) or 'none'}"


class NameNotFoundError(ShoecalError):
    """A name that does not exist among the ones that do.

    Attributes:
        name: what was asked for.
        available: what there is.
    """

    def __init__(self, kind: str, name: str, available: Sequence[str]) -> None:
        self.kind = kind
        self.name = name
        self.available = tuple(available)
        super().__init__(f"no {kind} named '{name}' ({instead(name, self.available)})")


class ShapeError(ShoecalError):
    """An array of another shape than expected."""

    def __init__(self, name: str, expected: str, got: tuple[int, ...]) -> None:
        self.expected = expected
        self.got = got
        super().__init__(f"{name}: expected shape {expected}, got {got}")


def error_code(kind: type[ShoecalError]) -> str:
    """What a program knows an error by: `NameNotFoundError` is `name-not-found`."""
    if kind is ShoecalError:
        return "refused"
    return re.sub(r"(?<!^)(?=[A-Z])", "-", kind.__name__.removesuffix("Error")).lower()


def _revive(kind: type[ShoecalError], args: tuple[object, ...]) -> ShoecalError:
    """An error as it was raised: its constructor takes other arguments than its message."""
    return kind.__new__(kind, *args)


class PartialError(ShoecalError):
    """Work of which a part could not be done; the rest was done and written.

    Attributes:
        figures: of what was done.
    """

    def __init__(self, message: str, figures: Mapping[str, object]) -> None:
        self.figures = figures
        super().__init__(message)


class ToldError(ShoecalError):
    """The message has been shown already, by another process; only the exit code is left."""

    def __init__(self) -> None:
        super().__init__("ended with the message above")
