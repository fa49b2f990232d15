"""What reads the command line: every command by name, and wrong usage reported in one line."""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NoReturn, Protocol, cast

from rich.console import Console

from shoecal_core.cli.suggestions import nearest, short_path
from shoecal_core.errors import ShoecalError
from shoecal_core.workspace import config_dir

COMMANDS = {
    "demo": "the main job on the simulated robot, over real ROS 2 nodes",
    "plan": "plan the motions of a self-calibration and check them",
    "simulate": "record a session of the simulated robot, without ROS",
    "calibrate": "find gains and offsets from a recorded session",
    "diagnose": "where model and reality differ, which effect causes it, and what cannot be known",
    "evaluate": "how far a calibration is off model, truth or another calibration",
    "history": "how a robot's gains and offsets changed from calibration to calibration",
    "apply": "recorded readings under a calibration: GRF and CoP of every sample, in tables",
    "correct": "what a recording or a diagnosis finds of the robot, into copies of its files",
    "manual": "calibrate with known weights: single cells, then the shoe",
    "check": "what is in a session, and is it fit for use",
    "recover": "rescue what can be read of a damaged run file",
    "new": "draft the files of a robot from its URDF",
    "import": "turn foreign recordings into a session",
    "completion": "a script that completes commands, options and names in a shell",
}
EPILOG = """\
a first calibration, on a simulated robot:
  shoecal simulate {robot} {shoe} --out out/session
  shoecal calibrate out/session --out out/calibration.yaml --report out/report.html

shoecal COMMAND --help describes each. Results go to standard output, progress and errors to
standard error."""
WIDEST = 100
"""Columns of a help text."""

_CHOICE = re.compile(r"invalid choice: '(?P<given>[^']*)' \(choose from (?P<known>.*)\)$")
_CHOICES = re.compile(r" \(choose from .*\)$")
_COUNT = re.compile(r"argument (?:[^ ]*/)?(?P<option>-[^ :]*): expected \d+ arguments$")
_UNKNOWN = re.compile(r"unrecognized arguments: (?P<given>.*)$")


class Command(Protocol):
    """What each module of `commands` offers."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""

    def run(self, args: argparse.Namespace, console: Console) -> Mapping[str, object]:
        """Do the work; figures for `--json`."""


class Parser(argparse.ArgumentParser):
    """Wrong usage is one line, with what was meant where it can be guessed."""

    def error(self, message: str) -> NoReturn:
        """Say it and end."""
        guess = self._guess(message)
        # Who mistyped one name need not read all others.
        text = f"{_CHOICES.sub('', message) if guess else message}{guess}"
        text += self._names(message)
        see = " See" if text.endswith("?") else "; see"
        self.exit(2, f"{self.prog}: {text}{see} {self.prog} --help\n")

    def _names(self, message: str) -> str:
        """`: NAME NAME …`, what an option with several values expects."""
        if found := _COUNT.match(message):
            for action in self._actions:
                if found["option"] in action.option_strings and isinstance(action.metavar, tuple):
                    return f": {' '.join(action.metavar)}"
        return ""

    def _guess(self, message: str) -> str:
        if found := _CHOICE.search(message):
            known = [name.strip(" '\"") for name in found["known"].split(",")]
            return nearest(found["given"], known)
        if found := _UNKNOWN.search(message):
            known = [option for parser in _all(self) for option in parser._option_string_actions]  # noqa: SLF001
            given = [word for word in found["given"].split() if word.startswith("-")]
            option = given[0].partition("=")[0] if given else ""
            return (_elsewhere(option) or nearest(option, known)) if option else ""
        return ""


def _elsewhere(option: str) -> str:
    """`; it belongs to NAME`: the commands that have an option, empty where none has it."""
    having = [
        name
        for name in COMMANDS
        if any(option in action.option_strings for action in actions_of(command_line([name])))
    ]
    return f"; it belongs to {', '.join(having)}" if having else ""


def command_line(wanted: Sequence[str]) -> Parser:
    """The parser, with the arguments of the commands that are wanted.

    Only those are imported: `shoecal --help` must not wait for solvers.
    """
    parser = Parser(
        prog="shoecal",
        description="Humanoids calibrate the force sensors in their own feet.",
        epilog=_epilog(),
        formatter_class=_Help,
    )
    parser.add_argument("--version", action="version", version=f"shoecal {_version()}")
    subparsers = parser.add_subparsers(dest="name", metavar="COMMAND", required=True)
    for name, summary in COMMANDS.items():
        subparser = subparsers.add_parser(
            name, help=summary, description=_sentence(summary), formatter_class=_Help
        )
        if name in wanted:
            module = importlib.import_module(f"shoecal_core.cli.{name}_command")
            command = cast(Command, module)
            command.add_arguments(subparser)
            subparser.add_argument(
                "--json", type=Path, metavar="FILE", help="also write the figures as JSON"
            )
            subparser.set_defaults(command=command)
    return parser


def actions_of(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Every argument of a parser and of the parsers within it."""
    for one in _all(parser):
        yield from one._actions  # noqa: SLF001 - argparse has it nowhere else


def _all(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:  # noqa: SLF001
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
            for inner in action.choices.values():
                yield from _all(inner)


class _Help(argparse.RawDescriptionHelpFormatter):
    def __init__(self, prog: str) -> None:
        width = min(WIDEST, shutil.get_terminal_size().columns) - 2
        super().__init__(prog, max_help_position=30, width=width)
        # argparse does not count the indent of commands.
        self._action_max_length = 4 + max(map(len, COMMANDS))

    def _get_help_string(self, action: argparse.Action) -> str | None:
        text = action.help
        silent = action.default in (None, argparse.SUPPRESS, (), []) or isinstance(
            action.default, bool
        )
        if text is None or silent or not action.option_strings or "default" in text:
            return text
        return f"{text} (default: %(default)s)"


def _epilog() -> str:
    """The first commands, with files that exist."""
    try:
        config = short_path(config_dir())
    except ShoecalError:  # an installation without its files; commands say so
        return EPILOG.format(robot="ROBOT.yaml", shoe="SHOE.yaml")
    return EPILOG.format(
        robot=config / "robots" / "nao.yaml", shoe=config / "shoes" / "nao_shoe.yaml"
    )


def _version() -> str:
    """Of the installed package; a checkout on the path alone has none."""
    try:
        return importlib.metadata.version("shoecal_core")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"


def _sentence(summary: str) -> str:
    return f"{summary[0].upper()}{summary[1:]}."
