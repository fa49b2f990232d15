"""The command line: `shoecal COMMAND …`.

Every command returns its figures as a mapping; `--json FILE` writes them for machines.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn, Protocol, cast

from rich.console import Console

from shoecal_core.errors import PartialError, ShoecalError, ToldError
from shoecal_core.files import atomic_write

COMMANDS = {
    "demo": "the main job on the simulated robot, over real ROS 2 nodes",
    "plan": "plan the motions of a self-calibration and check them",
    "simulate": "record a session of the simulated robot, without ROS",
    "calibrate": "find gains and offsets from a recorded session",
    "diagnose": "where model and reality differ, which effect causes it, and what cannot be known",
    "evaluate": "how far a calibration is off model, truth or another calibration",
    "manual": "calibrate with known weights: single cells, then the shoe",
    "check": "what is in a session, and is it fit for use",
    "recover": "rescue what can be read of a damaged run file",
    "new": "draft the files of a robot from its URDF",
    "import": "turn foreign recordings into a session",
}


PIPE_WIDTH = 140
"""Columns of what is piped or written to a file."""


class Command(Protocol):
    """What each module of `commands` offers."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""

    def run(self, args: argparse.Namespace, console: Console) -> Mapping[str, object]:
        """Do the work; figures for `--json`."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0 only on success."""
    args = _parse(sys.argv[1:] if argv is None else argv)
    # Results go to stdout, progress and errors to stderr: a pipe gets figures only.
    errors = Console(stderr=True, highlight=False)
    try:
        try:
            _write(args.json, args.command.run(args, _output()))
        except PartialError as error:
            _write(args.json, error.figures)
            raise
    except ToldError:
        return 1
    except ShoecalError as error:
        errors.print(f"[bold red]shoecal {args.name}:[/] {_plain(error)}", soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        errors.print(f"shoecal {args.name}: interrupted")
        return 130
    return 0


def _write(file: Path | None, figures: Mapping[str, object]) -> None:
    if file is not None:
        atomic_write(file, json.dumps(figures, indent=1, allow_nan=False) + "\n")


def _output() -> Console:
    """Standard output; wide enough for every table where nobody looks at a terminal."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=PIPE_WIDTH)


class _Parser(argparse.ArgumentParser):
    """Wrong usage is one line."""

    def error(self, message: str) -> NoReturn:
        """Say it and end."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def _parse(argv: Sequence[str]) -> argparse.Namespace:
    parser = _Parser(
        prog="shoecal",
        description="Humanoids calibrate the force sensors in their own feet.",
    )
    subparsers = parser.add_subparsers(dest="name", metavar="COMMAND", required=True)
    # Only the command asked for is imported: `shoecal --help` must not wait for solvers.
    wanted = next((word for word in argv if word in COMMANDS), None)
    for name, summary in COMMANDS.items():
        subparser = subparsers.add_parser(name, help=summary, description=_sentence(summary))
        if name == wanted:
            module = importlib.import_module(f"shoecal_core.commands.{name}_command")
            command = cast(Command, module)
            command.add_arguments(subparser)
            subparser.add_argument(
                "--json", type=Path, metavar="FILE", help="also write the figures as JSON"
            )
            subparser.set_defaults(command=command)
    return parser.parse_args(argv)


def _sentence(summary: str) -> str:
    return f"{summary[0].upper()}{summary[1:]}."


def _plain(error: ShoecalError) -> str:
    """One line, with nothing that the console would take for markup."""
    return " ".join(str(error).split()).replace("[", r"\[")


if __name__ == "__main__":
    sys.exit(main())
