"""The command line: every command with its arguments, as `--help` tells them."""

from __future__ import annotations

import argparse
import importlib
import inspect
import pkgutil
from collections.abc import Iterator

import shoecal_core
from reference.markdown import code, fenced, page, table
from shoecal_core.cli.parsers import COMMANDS
from shoecal_core.errors import FileError, ShoecalError, error_code

_LEAD = (
    "`shoecal COMMAND --help` tells the same. Results go to standard output, progress and errors "
    "to standard error; the exit code is 0 only on success, 1 for an error that is told in one "
    "line, 2 for a wrong argument."
)

_ERRORS = (
    "Where a command ends with 1, the file of `--json` holds, beside the figures of what was done, "
    "`error`: its `code`, the `message` that was told, and of an error with a file `file` and "
    "`field` (empty: the file as a whole)."
)


def commands_page() -> str:
    """The page."""
    parts: list[str] = []
    for name, summary in COMMANDS.items():
        parser = command_parser(name)
        parts += [f"## shoecal {name}", f"{summary[0].upper()}{summary[1:]}."]
        for one in _with_inner(parser):
            if one is not parser:
                parts.append(f"### {one.prog}")
            parts += [fenced(_usage(one)), _arguments(one)]
    parts += ["## Errors for programs", _ERRORS, table(("code", "what it is"), _codes())]
    return page("Commands", _LEAD, parts)


def command_parser(name: str) -> argparse.ArgumentParser:
    """What reads the arguments of one command."""
    parser = argparse.ArgumentParser(prog=f"shoecal {name}")
    importlib.import_module(f"shoecal_core.cli.{name}_command").add_arguments(parser)
    parser.add_argument("--json", metavar="FILE", help="also write the figures as JSON")
    return parser


def _codes() -> list[tuple[str, str]]:
    """Code and meaning of every error of the library, in the codes' order."""
    for module in pkgutil.walk_packages(shoecal_core.__path__, f"{shoecal_core.__name__}."):
        importlib.import_module(module.name)
    rows: dict[str, list[str]] = {}
    waiting = [ShoecalError]
    while waiting:
        kind = waiting.pop()
        waiting += kind.__subclasses__()
        if not kind.__module__.startswith(f"{shoecal_core.__name__}."):
            continue
        about = (inspect.getdoc(kind) or "").splitlines()[0]
        rows.setdefault(code(error_code(kind)), []).append(about)
    del rows[code(error_code(FileError))]  # always told as one of its kinds
    rows[code(error_code(ShoecalError))] = ["Anything else; the message tells what."]
    return [(name, " Or: ".join(sorted(set(about)))) for name, about in sorted(rows.items())]


def _with_inner(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:  # noqa: SLF001 - argparse tells it nowhere else
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
            for inner in action.choices.values():
                yield from _with_inner(inner)


def _usage(parser: argparse.ArgumentParser) -> str:
    """Not argparse's own, which is worded otherwise from one Python to the next."""
    required = [
        f"{action.option_strings[0]} {action.metavar or action.dest.upper()}"
        for action in parser._actions  # noqa: SLF001
        if action.option_strings and action.required
    ]
    places = [
        f"{action.dest.upper()}{' …' if action.nargs in ('+', '*') else ''}"
        for action in parser._actions  # noqa: SLF001
        if not action.option_strings and not isinstance(action, argparse._SubParsersAction)  # noqa: SLF001
    ]
    return " ".join((parser.prog, *places, *required, "[options]"))


def _arguments(parser: argparse.ArgumentParser) -> str:
    rows = []
    for action in parser._actions:  # noqa: SLF001
        if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):  # noqa: SLF001
            continue
        name = ", ".join(action.option_strings) or str(action.metavar or action.dest)
        rows.append((code(name), _default(action), _help(parser, action)))
    return table(("argument", "default", "what it is"), rows) if rows else ""


def _default(action: argparse.Action) -> str:
    if action.default in (None, (), [], False, argparse.SUPPRESS):
        return ""
    return code(action.default)


def _help(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    if not action.help:
        return ""
    return (
        action.help % {"prog": parser.prog, **vars(action)}
        if "%(" in action.help
        else (action.help.replace("%%", "%"))
    )
