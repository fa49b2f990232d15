"""The command line: `shoecal COMMAND …`.

Every command returns its figures as a mapping; `--json FILE` writes them for machines, and why it
could not be done.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from rich.console import Console
from rich.markup import escape

import shoecal_core.one_thread  # noqa: F401  (before anything that loads numpy)
from shoecal_core.cli.parsers import COMMANDS, command_line
from shoecal_core.cli.progress import still_working
from shoecal_core.cli.prose import output
from shoecal_core.cli.suggestions import nearest_file
from shoecal_core.errors import (
    FileError,
    FileMissingError,
    PartialError,
    ShoecalError,
    ToldError,
    error_code,
)
from shoecal_core.files import atomic_write

STEPLESS = ("calibrate", "check", "evaluate", "import")
"""Commands that take long and name no steps, with one session."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0 only on success."""
    words = sys.argv[1:] if argv is None else argv
    if not words:
        command_line(()).print_help(sys.stderr)
        return 2
    args = command_line([word for word in words if word in COMMANDS][:1]).parse_args(words)
    # Results go to stdout, progress and errors to stderr: a pipe gets figures only.
    errors = Console(stderr=True, highlight=False, emoji=False)
    try:
        try:
            with nullcontext() if _has_steps(args) else still_working(args.name):
                figures = args.command.run(args, output())
            _write(args.json, figures)
        except ShoecalError as error:
            with suppress(FileError):  # where this file is the faulty one, it is reported below
                _write(args.json, _why(error))
            raise
    except ToldError:
        return 1
    except ShoecalError as error:
        text = f"{_plain(error)}{escape(_meant(error))}"
        errors.print(f"[bold red]shoecal {args.name}:[/] {text}", soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        errors.print(f"shoecal {args.name}: interrupted")
        return 130
    return 0


def _has_steps(args: argparse.Namespace) -> bool:
    """Whether a command says by itself how far it is: each of many sessions is a step."""
    return args.name not in STEPLESS or len(getattr(args, "sessions", ())) > 1


def _write(file: Path | None, figures: Mapping[str, object]) -> None:
    if file is not None:
        atomic_write(file, json.dumps(figures, indent=1, allow_nan=False) + "\n")


def _why(error: ShoecalError) -> dict[str, object]:
    """An error for a program, with the figures of what was done."""
    figures = error.figures if isinstance(error, PartialError) else {}
    content = {"code": error_code(type(error)), "message": str(error)}
    if isinstance(error, FileError):
        content |= {"file": str(error.path), "field": error.field}
    return {**figures, "error": content}


def _meant(error: ShoecalError) -> str:
    """Of a file that should be there and is not: what may have been meant."""
    return nearest_file(error.path, error.named) if isinstance(error, FileMissingError) else ""


def _plain(error: ShoecalError) -> str:
    """One line, with nothing that the console would take for markup."""
    return " ".join(str(error).split()).replace("[", r"\[")
