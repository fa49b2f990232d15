"""`shoecal completion SHELL`: a script that completes commands, options and names.

It is made once, and holds all that it completes: pressing the tabulator starts no Python.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

from rich.console import Console

from shoecal_core.cli.parsers import COMMANDS, actions_of, command_line
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.motion_sets import MOTION_SETS

SHELLS = {
    "bash": "shoecal completion bash > ~/.local/share/bash-completion/completions/shoecal",
    "zsh": "shoecal completion zsh > a folder of $fpath, as _shoecal",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    listed = "; ".join(f"{shell}: {how}" for shell, how in SHELLS.items())
    parser.add_argument(
        "shell", choices=list(SHELLS), metavar="SHELL", help=f"{', '.join(SHELLS)}. {listed}"
    )


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Print the script."""
    script = completion_script(args.shell)
    console.file.write(script if script.endswith("\n") else f"{script}\n")
    return {"shell": args.shell, "commands": list(COMMANDS)}


def completion_script(shell: str) -> str:
    """The script for one of SHELLS."""
    shtab = _shtab()
    parser = command_line(list(COMMANDS))
    names = {
        "only": [effect.identifier for effect in EFFECTS],
        "motions": (*MOTION_SETS, *MOTION_KINDS),
    }
    for action in actions_of(parser):
        if action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
        elif action.dest in names:
            action.choices = list(names[action.dest])
    return str(shtab.complete(parser, shell))


def _shtab() -> ModuleType:
    """It has no rosdep key, so an installation from packages may lack it."""
    try:
        return importlib.import_module("shtab")
    except ImportError as error:
        raise ShoecalError(
            "completion needs shtab, which is not installed: sudo apt install python3-shtab, or "
            "pip install shtab"
        ) from error
